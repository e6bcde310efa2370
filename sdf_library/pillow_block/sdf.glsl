#include "lib/operators.glsl"
#include "lib/solids.glsl"

float polygon7(vec2 p) {
    vec2 to, away;
    float d = 1e9, side = 1.0;
    to = p - vec2(0.4, -0.46);
    away = to - vec2(0.15, 0.0) * clamp(dot(to, vec2(6.66666667, 0.0)), 0.0, 1.0);
    d = min(d, dot(away, away));
    to = p - vec2(0.55, -0.46);
    away = to - vec2(-0.15, 0.36) * clamp(dot(to, vec2(-0.986193294, 2.36686391)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (p.y >= -0.46 && p.y < -0.1 && dot(to, vec2(0.36, 0.15)) < 0.0) side = -side;
    to = p - vec2(0.4, -0.1);
    away = to - vec2(0.0, -0.36) * clamp(dot(to, vec2(0.0, -2.77777778)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (p.y >= -0.46 && p.y < -0.1 && dot(to, vec2(-0.36, 0.0)) > 0.0) side = -side;
    return side * sqrt(d);
}

float part30(vec3 p) {
    vec3 p29 = p - vec3(0.235, 0.0, 0.0);
    return (length(p29) - 0.058);
}

float polar31(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part30(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part30(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part40(vec3 p) {
    vec3 p39 = p - vec3(0.235, 0.0, 0.0);
    return (length(p39) - 0.064);
}

float polar41(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part40(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part40(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float wheel45(vec2 p) {
    float turn = atan(-p.x, p.y), sector = 1.04719755;
    turn = abs(turn - sector * round(turn / sector));
    vec2 q = length(p) * vec2(cos(turn), sin(turn)), to, away;
    float d = 1e9, side = 0.0;
    to = q - vec2(0.05, 0.0);
    away = to - vec2(-0.0125, 0.0216506351) * clamp(dot(to, vec2(-20.0, 34.6410162)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (q.y * 0.05 >= q.x * 0.0) side = dot(to, vec2(0.0216506351, 0.0125));
    return sign(side) * sqrt(d);
}

float wheel56(vec2 p) {
    float turn = atan(-p.x, p.y), sector = 1.04719755;
    turn = abs(turn - sector * round(turn / sector));
    vec2 q = length(p) * vec2(cos(turn), sin(turn)), to, away;
    float d = 1e9, side = 0.0;
    to = q - vec2(0.078, 0.0);
    away = to - vec2(-0.0195, 0.0337749907) * clamp(dot(to, vec2(-12.8205128, 22.2057796)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (q.y * 0.078 >= q.x * 0.0) side = dot(to, vec2(0.0337749907, 0.0195));
    return sign(side) * sqrt(d);
}

float polygon66(vec2 p) {
    vec2 to, away;
    float d = 1e9, side = 1.0;
    to = p - vec2(-0.13, -0.01);
    away = to - vec2(0.26, 0.0) * clamp(dot(to, vec2(3.84615385, 0.0)), 0.0, 1.0);
    d = min(d, dot(away, away));
    to = p - vec2(0.13, -0.01);
    away = to - vec2(-0.02, 0.02) * clamp(dot(to, vec2(-25.0, 25.0)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (p.y >= -0.01 && p.y < 0.01 && dot(to, vec2(0.02, 0.02)) < 0.0) side = -side;
    to = p - vec2(0.11, 0.01);
    away = to - vec2(-0.22, 0.0) * clamp(dot(to, vec2(-4.54545455, 0.0)), 0.0, 1.0);
    d = min(d, dot(away, away));
    to = p - vec2(-0.11, 0.01);
    away = to - vec2(-0.02, -0.02) * clamp(dot(to, vec2(-25.0, -25.0)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (p.y >= -0.01 && p.y < 0.01 && dot(to, vec2(-0.02, 0.02)) > 0.0) side = -side;
    return side * sqrt(d);
}

float polygon69(vec2 p) {
    vec2 to, away;
    float d = 1e9, side = 1.0;
    to = p - vec2(-0.11, -0.01);
    away = to - vec2(0.22, 0.0) * clamp(dot(to, vec2(4.54545455, 0.0)), 0.0, 1.0);
    d = min(d, dot(away, away));
    to = p - vec2(0.11, -0.01);
    away = to - vec2(0.02, 0.02) * clamp(dot(to, vec2(25.0, 25.0)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (p.y >= -0.01 && p.y < 0.01 && dot(to, vec2(0.02, -0.02)) < 0.0) side = -side;
    to = p - vec2(0.13, 0.01);
    away = to - vec2(-0.26, 0.0) * clamp(dot(to, vec2(-3.84615385, 0.0)), 0.0, 1.0);
    d = min(d, dot(away, away));
    to = p - vec2(-0.13, 0.01);
    away = to - vec2(0.02, -0.02) * clamp(dot(to, vec2(25.0, -25.0)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (p.y >= -0.01 && p.y < 0.01 && dot(to, vec2(-0.02, -0.02)) > 0.0) side = -side;
    return side * sqrt(d);
}

float wheel78(vec2 p) {
    float turn = atan(p.y, p.x), sector = 0.241660973;
    turn = abs(turn - sector * round(turn / sector));
    vec2 q = length(p) * vec2(cos(turn), sin(turn)), to, away;
    float d = 1e9, side = 0.0;
    to = q - vec2(0.499416113, 0.0);
    away = to - vec2(0.0, 0.0241566898) * clamp(dot(to, vec2(0.0, 41.3964003)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (q.y * 0.499416113 >= q.x * 0.0) side = dot(to, vec2(0.0241566898, 0.0));
    to = q - vec2(0.499416113, 0.0241566898);
    away = to - vec2(-0.0755325248, 0.00662810031) * clamp(dot(to, vec2(-13.1381613, 1.15289475)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (q.y * 0.499416113 >= q.x * 0.0241566898) side = dot(to, vec2(0.00662810031, 0.0755325248));
    to = q - vec2(0.423883589, 0.0307847901);
    away = to - vec2(-0.00247500211, 0.0203834763) * clamp(dot(to, vec2(-5.87033491, 48.3465576)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (q.y * 0.423883589 >= q.x * 0.0307847901) side = dot(to, vec2(0.0203834763, 0.00247500211));
    return sign(side) * sqrt(d);
}

float part86(vec3 p) {
    vec3 p84 = p - vec3(0.285, 0.0, 0.0);
    vec2 p85 = vec2(length(p84.xz) - 0.0, p84.y);
    return (length(max(abs(p85) - vec2(0.07, 0.5), 0.0)) + min(max((abs(p85) - vec2(0.07, 0.5)).x, (abs(p85) - vec2(0.07, 0.5)).y), 0.0));
}

float polar87(vec3 p) {
    float home = round(atan(p.z, p.x) * 0.954929659) * 1.04719755;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part86(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.5, h = i == 0 ? 0.866025404 : -0.866025404;
        d = min(d, part86(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part115(vec3 p) {
    vec3 p93 = p - vec3(0.0, 0.05, 0.0);
    vec2 p94 = p93.xy;
    vec2 p95 = p94 - vec2(0.0, -0.27);
    vec3 p96 = p - vec3(0.0, -0.46, 0.0);
    vec3 p97 = vec3(abs(p.x), p.y, p.z);
    vec2 p98 = p97.xy;
    vec3 p99 = p - vec3(0.0, 0.05, 0.0);
    vec3 p100 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p99;
    vec2 p101 = vec2(length(p100.xz) - 0.0, p100.y);
    vec3 p102 = vec3(abs(p.x), p.y, p.z);
    vec3 p103 = p102 - vec3(0.63, -0.46, 0.0);
    vec2 p104 = vec2(length(p103.xz) - 0.0, p103.y);
    vec3 p105 = p - vec3(0.0, 0.05, 0.0);
    vec3 p106 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p105;
    vec2 p107 = vec2(length(p106.xz) - 0.365, p106.y);
    vec3 p108 = p - vec3(0.58, 0.57, -0.47);
    vec3 p109 = p - vec3(0.0, 0.05, 0.0);
    vec3 p110 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p109;
    vec2 p111 = vec2(length(p110.xz) - 0.305, p110.y);
    vec2 p112 = vec2(length(p110.xz) - 0.235, p110.y);
    vec3 p113 = p - vec3(0.58, 0.57, -0.47);
    vec3 p114 = p - vec3(0.58, 0.57, -0.47);
    return max(min(max(min(max(max(opSmoothUnion(opSmoothUnion((opExtrude(opSmoothUnion((length(p94) - 0.44), (length(max(abs(p95) - vec2(0.44, 0.25), 0.0)) + min(max((abs(p95) - vec2(0.44, 0.25)).x, (abs(p95) - vec2(0.44, 0.25)).y), 0.0)), 0.05), p93.z, 0.15) - 0.015), (sdBox3(p96, vec3(0.72, 0.03, 0.15)) - 0.03), 0.06), (opExtrude(polygon7(p98), p97.z, 0.035) - 0.012), 0.03), -((length(max(abs(p101) - vec2(0.345, 0.5), 0.0)) + min(max((abs(p101) - vec2(0.345, 0.5)).x, (abs(p101) - vec2(0.345, 0.5)).y), 0.0)))), -((length(max(abs(p104) - vec2(0.055, 0.2), 0.0)) + min(max((abs(p104) - vec2(0.055, 0.2)).x, (abs(p104) - vec2(0.055, 0.2)).y), 0.0)))), ((length(max(abs(p107) - vec2(0.01, 0.18), 0.0)) + min(max((abs(p107) - vec2(0.01, 0.18)).x, (abs(p107) - vec2(0.01, 0.18)).y), 0.0)) - 0.01)), -(sdBox3(p108, vec3(0.5, 0.5, 0.5)))), max(max(((length(max(abs(p111) - vec2(0.028, 0.118), 0.0)) + min(max((abs(p111) - vec2(0.028, 0.118)).x, (abs(p111) - vec2(0.028, 0.118)).y), 0.0)) - 0.012), -((length(p112) - 0.062))), -(sdBox3(p113, vec3(0.5, 0.5, 0.5))))), (sdBox3(p114, vec3(0.5, 0.5, 0.5)) - 0.004));
}

float part132(vec3 p) {
    vec3 p116 = p - vec3(0.0, 0.05, 0.0);
    vec2 p117 = p116.xy;
    vec2 p118 = p117 - vec2(0.0, -0.27);
    vec3 p119 = p - vec3(0.0, -0.46, 0.0);
    vec3 p120 = vec3(abs(p.x), p.y, p.z);
    vec2 p121 = p120.xy;
    vec3 p122 = p - vec3(0.0, 0.05, 0.0);
    vec3 p123 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p122;
    vec2 p124 = vec2(length(p123.xz) - 0.0, p123.y);
    vec3 p125 = vec3(abs(p.x), p.y, p.z);
    vec3 p126 = p125 - vec3(0.63, -0.46, 0.0);
    vec2 p127 = vec2(length(p126.xz) - 0.0, p126.y);
    vec3 p128 = p - vec3(0.0, 0.05, 0.0);
    vec3 p129 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p128;
    vec2 p130 = vec2(length(p129.xz) - 0.365, p129.y);
    vec3 p131 = p - vec3(0.58, 0.57, -0.47);
    return max(min(max(max(opSmoothUnion(opSmoothUnion((opExtrude(opSmoothUnion((length(p117) - 0.44), (length(max(abs(p118) - vec2(0.44, 0.25), 0.0)) + min(max((abs(p118) - vec2(0.44, 0.25)).x, (abs(p118) - vec2(0.44, 0.25)).y), 0.0)), 0.05), p116.z, 0.15) - 0.015), (sdBox3(p119, vec3(0.72, 0.03, 0.15)) - 0.03), 0.06), (opExtrude(polygon7(p121), p120.z, 0.035) - 0.012), 0.03), -((length(max(abs(p124) - vec2(0.345, 0.5), 0.0)) + min(max((abs(p124) - vec2(0.345, 0.5)).x, (abs(p124) - vec2(0.345, 0.5)).y), 0.0)))), -((length(max(abs(p127) - vec2(0.055, 0.2), 0.0)) + min(max((abs(p127) - vec2(0.055, 0.2)).x, (abs(p127) - vec2(0.055, 0.2)).y), 0.0)))), ((length(max(abs(p130) - vec2(0.01, 0.18), 0.0)) + min(max((abs(p130) - vec2(0.01, 0.18)).x, (abs(p130) - vec2(0.01, 0.18)).y), 0.0)) - 0.01)), -(sdBox3(p131, vec3(0.5, 0.5, 0.5))));
}

float part163(vec3 p) {
    vec3 p133 = p - vec3(0.0, 0.05, 0.0);
    vec3 p134 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p133;
    vec2 p135 = vec2(length(p134.xz) - 0.305, p134.y);
    vec2 p136 = vec2(length(p134.xz) - 0.235, p134.y);
    vec3 p137 = p - vec3(0.58, 0.57, -0.47);
    vec3 p138 = p - vec3(0.0, 0.05, 0.0);
    vec3 p139 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p138;
    vec2 p140 = vec2(length(p139.xz) - 0.165, p139.y);
    vec2 p141 = vec2(length(p139.xz) - 0.235, p139.y);
    vec3 p142 = vec3(abs(p.x), p.y, p.z);
    vec3 p143 = p142 - vec3(0.63, 0.0, 0.0);
    vec3 p144 = p143 - vec3(0.0, -0.388, 0.0);
    vec2 p145 = vec2(length(p144.xz) - 0.0, p144.y);
    vec3 p146 = p143 - vec3(0.0, -0.342, 0.0);
    vec3 p147 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p146;
    vec2 p148 = p147.xy;
    vec3 p149 = p146 - vec3(0.0, -0.018, 0.0);
    vec3 p150 = p143 - vec3(0.0, -0.45, 0.0);
    vec2 p151 = vec2(length(p150.xz) - 0.0, p150.y);
    vec3 p152 = p - vec3(0.0, 0.05, 0.0);
    vec3 p153 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p152;
    vec3 p154 = p153 - vec3(0.0, 0.13, 0.0);
    vec2 p155 = vec2(length(p154.xz) - 0.0, p154.y);
    vec3 p156 = p153 - vec3(0.0, 0.69, 0.0);
    vec2 p157 = vec2(length(p156.xz) - 0.0, p156.y);
    vec3 p158 = p153 - vec3(0.0, -0.43, 0.0);
    vec2 p159 = vec2(length(p158.xz) - 0.0, p158.y);
    vec3 p160 = p153 - vec3(0.0, 0.19, 0.0);
    vec2 p161 = vec2(length(p160.xz) - 0.1325, p160.y);
    vec3 p162 = p153 - vec3(0.0, -0.38, -0.13);
    return min(min(min(max(max(((length(max(abs(p135) - vec2(0.028, 0.118), 0.0)) + min(max((abs(p135) - vec2(0.028, 0.118)).x, (abs(p135) - vec2(0.028, 0.118)).y), 0.0)) - 0.012), -((length(p136) - 0.062))), -(sdBox3(p137, vec3(0.5, 0.5, 0.5)))), max(((length(max(abs(p140) - vec2(0.023, 0.118), 0.0)) + min(max((abs(p140) - vec2(0.023, 0.118)).x, (abs(p140) - vec2(0.023, 0.118)).y), 0.0)) - 0.012), -((length(p141) - 0.062)))), min(min(((length(max(abs(p145) - vec2(0.089, 0.006), 0.0)) + min(max((abs(p145) - vec2(0.089, 0.006)).x, (abs(p145) - vec2(0.089, 0.006)).y), 0.0)) - 0.006), max(opExtrude(wheel56(p148), p147.z, 0.035), (length(p149) - 0.093))), (length(max(abs(p151) - vec2(0.05, 0.1), 0.0)) + min(max((abs(p151) - vec2(0.05, 0.1)).x, (abs(p151) - vec2(0.05, 0.1)).y), 0.0)))), max(min(min(min((length(max(abs(p155) - vec2(0.13, 0.55), 0.0)) + min(max((abs(p155) - vec2(0.13, 0.55)).x, (abs(p155) - vec2(0.13, 0.55)).y), 0.0)), polygon66(p157)), polygon69(p159)), ((length(max(abs(p161) - vec2(0.0225, 0.03), 0.0)) + min(max((abs(p161) - vec2(0.0225, 0.03)).x, (abs(p161) - vec2(0.0225, 0.03)).y), 0.0)) - 0.01)), -(sdBox3(p162, vec3(0.025, 0.15, 0.03)))));
}

float part167(vec3 p) {
    vec3 p166 = p - vec3(0.235, 0.0, 0.0);
    return (length(p166) - 0.058);
}

float polar168(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part167(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part167(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part169(vec3 p) {
    vec3 p164 = p - vec3(0.0, 0.05, 0.0);
    vec3 p165 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p164;
    return polar168(p165);
}

float part178(vec3 p) {
    vec3 p177 = p - vec3(0.235, 0.0, 0.0);
    return (length(p177) - 0.064);
}

float polar179(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part178(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part178(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part189(vec3 p) {
    vec3 p170 = p - vec3(0.0, 0.05, 0.0);
    vec3 p171 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p170;
    vec3 p172 = p171 - vec3(0.0, -0.06, 0.0);
    vec2 p173 = vec2(length(p172.xz) - 0.235, p172.y);
    vec3 p174 = p171 - vec3(0.0, 0.06, 0.0);
    vec2 p175 = vec2(length(p174.xz) - 0.235, p174.y);
    vec2 p176 = vec2(length(p171.xz) - 0.235, p171.y);
    vec3 p180 = p - vec3(0.0, 0.52, 0.0);
    vec3 p181 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p180;
    vec2 p182 = p181.xy;
    vec3 p183 = p - vec3(0.0, 0.56, 0.0);
    vec2 p184 = vec2(length(p183.xz) - 0.0, p183.y);
    vec3 p185 = p - vec3(0.0, 0.61, 0.0);
    vec3 p186 = p - vec3(0.0, 0.05, 0.0);
    vec3 p187 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p186;
    vec3 p188 = p187 - vec3(0.0, -0.31, -0.135);
    return min(min(max(min(min(((length(max(abs(p173) - vec2(0.013, 0.007), 0.0)) + min(max((abs(p173) - vec2(0.013, 0.007)).x, (abs(p173) - vec2(0.013, 0.007)).y), 0.0)) - 0.005), ((length(max(abs(p175) - vec2(0.013, 0.007), 0.0)) + min(max((abs(p175) - vec2(0.013, 0.007)).x, (abs(p175) - vec2(0.013, 0.007)).y), 0.0)) - 0.005)), ((length(max(abs(p176) - vec2(0.008, 0.056), 0.0)) + min(max((abs(p176) - vec2(0.008, 0.056)).x, (abs(p176) - vec2(0.008, 0.056)).y), 0.0)) - 0.004)), -(polar179(p171))), min(min((opExtrude(wheel45(p182), p181.z, 0.025) - 0.004), (length(max(abs(p184) - vec2(0.022, 0.05), 0.0)) + min(max((abs(p184) - vec2(0.022, 0.05)).x, (abs(p184) - vec2(0.022, 0.05)).y), 0.0))), (length(p185) - 0.032))), (sdBox3(p188, vec3(0.015, 0.067, 0.022)) - 0.008));
}

float part199(vec3 p) {
    vec3 p197 = p - vec3(0.285, 0.0, 0.0);
    vec2 p198 = vec2(length(p197.xz) - 0.0, p197.y);
    return (length(max(abs(p198) - vec2(0.07, 0.5), 0.0)) + min(max((abs(p198) - vec2(0.07, 0.5)).x, (abs(p198) - vec2(0.07, 0.5)).y), 0.0));
}

float polar200(vec3 p) {
    float home = round(atan(p.z, p.x) * 0.954929659) * 1.04719755;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part199(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.5, h = i == 0 ? 0.866025404 : -0.866025404;
        d = min(d, part199(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part205(vec3 p) {
    vec3 p190 = p - vec3(0.0, 0.05, 0.45);
    vec2 p191 = p190.xy;
    vec3 p192 = p190 - vec3(0.0, 0.0, 0.075);
    vec2 p193 = p192.xy;
    vec3 p194 = p190 - vec3(0.0, 0.0, -0.075);
    vec2 p195 = p194.xy;
    vec3 p196 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p190;
    vec2 p201 = p190.xy;
    vec3 p202 = p - vec3(0.0, 0.05, 0.0);
    vec3 p203 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p202;
    vec2 p204 = vec2(length(p203.xz) - 0.0, p203.y);
    return max(min(max(max(max((opExtrude(wheel78(p191), p190.z, 0.075) - 0.006), -(opExtrude((abs((length(p193) - 0.285)) - 0.105), p192.z, 0.03))), -(opExtrude((abs((length(p195) - 0.285)) - 0.105), p194.z, 0.03))), -(polar200(p196))), (opExtrude((length(p201) - 0.19), p190.z, 0.11) - 0.01)), -((length(max(abs(p204) - vec2(0.129, 1.5), 0.0)) + min(max((abs(p204) - vec2(0.129, 1.5)).x, (abs(p204) - vec2(0.129, 1.5)).y), 0.0))));
}

float part207(vec3 p) {
    vec3 p206 = p - vec3(0.0, -0.555, 0.15);
    return (sdBox3(p206, vec3(0.87, 0.005, 0.62)) - 0.03);
}

vec3 albedo(vec3 p, vec3 n) {
    float nearest = 1e9, d;
    vec3 colour = vec3(0.5);
    d = part115(p);
    if (d < nearest) { nearest = d; colour = vec3(0.5, 0.07, 0.04); }
    d = part132(p);
    if (d < nearest) { nearest = d; colour = vec3(0.05, 0.16, 0.3); }
    d = part163(p);
    if (d < nearest) { nearest = d; colour = vec3(0.42, 0.43, 0.45); }
    d = part169(p);
    if (d < nearest) { nearest = d; colour = vec3(0.6, 0.61, 0.63); }
    d = part189(p);
    if (d < nearest) { nearest = d; colour = vec3(0.58, 0.38, 0.1); }
    d = part205(p);
    if (d < nearest) { nearest = d; colour = vec3(0.34, 0.3, 0.26); }
    d = part207(p);
    if (d < nearest) { nearest = d; colour = vec3(0.34, 0.23, 0.14); }
    return colour;
}

float sdf(vec3 p) {
    vec3 p1 = p - vec3(0.0, 0.05, 0.0);
    vec2 p2 = p1.xy;
    vec2 p3 = p2 - vec2(0.0, -0.27);
    vec3 p4 = p - vec3(0.0, -0.46, 0.0);
    vec3 p5 = vec3(abs(p.x), p.y, p.z);
    vec2 p6 = p5.xy;
    vec3 p8 = p - vec3(0.0, 0.05, 0.0);
    vec3 p9 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p8;
    vec2 p10 = vec2(length(p9.xz) - 0.0, p9.y);
    vec3 p11 = vec3(abs(p.x), p.y, p.z);
    vec3 p12 = p11 - vec3(0.63, -0.46, 0.0);
    vec2 p13 = vec2(length(p12.xz) - 0.0, p12.y);
    vec3 p14 = p - vec3(0.0, 0.05, 0.0);
    vec3 p15 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p14;
    vec2 p16 = vec2(length(p15.xz) - 0.365, p15.y);
    vec3 p17 = p - vec3(0.58, 0.57, -0.47);
    vec3 p18 = p - vec3(0.0, 0.05, 0.0);
    vec3 p19 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p18;
    vec2 p20 = vec2(length(p19.xz) - 0.305, p19.y);
    vec2 p21 = vec2(length(p19.xz) - 0.235, p19.y);
    vec3 p22 = p - vec3(0.58, 0.57, -0.47);
    vec3 p23 = p - vec3(0.0, 0.05, 0.0);
    vec3 p24 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p23;
    vec2 p25 = vec2(length(p24.xz) - 0.165, p24.y);
    vec2 p26 = vec2(length(p24.xz) - 0.235, p24.y);
    vec3 p27 = p - vec3(0.0, 0.05, 0.0);
    vec3 p28 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p27;
    vec3 p32 = p - vec3(0.0, 0.05, 0.0);
    vec3 p33 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p32;
    vec3 p34 = p33 - vec3(0.0, -0.06, 0.0);
    vec2 p35 = vec2(length(p34.xz) - 0.235, p34.y);
    vec3 p36 = p33 - vec3(0.0, 0.06, 0.0);
    vec2 p37 = vec2(length(p36.xz) - 0.235, p36.y);
    vec2 p38 = vec2(length(p33.xz) - 0.235, p33.y);
    vec3 p42 = p - vec3(0.0, 0.52, 0.0);
    vec3 p43 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p42;
    vec2 p44 = p43.xy;
    vec3 p46 = p - vec3(0.0, 0.56, 0.0);
    vec2 p47 = vec2(length(p46.xz) - 0.0, p46.y);
    vec3 p48 = p - vec3(0.0, 0.61, 0.0);
    vec3 p49 = vec3(abs(p.x), p.y, p.z);
    vec3 p50 = p49 - vec3(0.63, 0.0, 0.0);
    vec3 p51 = p50 - vec3(0.0, -0.388, 0.0);
    vec2 p52 = vec2(length(p51.xz) - 0.0, p51.y);
    vec3 p53 = p50 - vec3(0.0, -0.342, 0.0);
    vec3 p54 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p53;
    vec2 p55 = p54.xy;
    vec3 p57 = p53 - vec3(0.0, -0.018, 0.0);
    vec3 p58 = p50 - vec3(0.0, -0.45, 0.0);
    vec2 p59 = vec2(length(p58.xz) - 0.0, p58.y);
    vec3 p60 = p - vec3(0.0, 0.05, 0.0);
    vec3 p61 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p60;
    vec3 p62 = p61 - vec3(0.0, 0.13, 0.0);
    vec2 p63 = vec2(length(p62.xz) - 0.0, p62.y);
    vec3 p64 = p61 - vec3(0.0, 0.69, 0.0);
    vec2 p65 = vec2(length(p64.xz) - 0.0, p64.y);
    vec3 p67 = p61 - vec3(0.0, -0.43, 0.0);
    vec2 p68 = vec2(length(p67.xz) - 0.0, p67.y);
    vec3 p70 = p61 - vec3(0.0, 0.19, 0.0);
    vec2 p71 = vec2(length(p70.xz) - 0.1325, p70.y);
    vec3 p72 = p61 - vec3(0.0, -0.38, -0.13);
    vec3 p73 = p - vec3(0.0, 0.05, 0.0);
    vec3 p74 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p73;
    vec3 p75 = p74 - vec3(0.0, -0.31, -0.135);
    vec3 p76 = p - vec3(0.0, 0.05, 0.45);
    vec2 p77 = p76.xy;
    vec3 p79 = p76 - vec3(0.0, 0.0, 0.075);
    vec2 p80 = p79.xy;
    vec3 p81 = p76 - vec3(0.0, 0.0, -0.075);
    vec2 p82 = p81.xy;
    vec3 p83 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p76;
    vec2 p88 = p76.xy;
    vec3 p89 = p - vec3(0.0, 0.05, 0.0);
    vec3 p90 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p89;
    vec2 p91 = vec2(length(p90.xz) - 0.0, p90.y);
    vec3 p92 = p - vec3(0.0, -0.555, 0.15);
    return min(min(min(min(min(min(min(min(min(min(max(min(max(max(opSmoothUnion(opSmoothUnion((opExtrude(opSmoothUnion((length(p2) - 0.44), (length(max(abs(p3) - vec2(0.44, 0.25), 0.0)) + min(max((abs(p3) - vec2(0.44, 0.25)).x, (abs(p3) - vec2(0.44, 0.25)).y), 0.0)), 0.05), p1.z, 0.15) - 0.015), (sdBox3(p4, vec3(0.72, 0.03, 0.15)) - 0.03), 0.06), (opExtrude(polygon7(p6), p5.z, 0.035) - 0.012), 0.03), -((length(max(abs(p10) - vec2(0.345, 0.5), 0.0)) + min(max((abs(p10) - vec2(0.345, 0.5)).x, (abs(p10) - vec2(0.345, 0.5)).y), 0.0)))), -((length(max(abs(p13) - vec2(0.055, 0.2), 0.0)) + min(max((abs(p13) - vec2(0.055, 0.2)).x, (abs(p13) - vec2(0.055, 0.2)).y), 0.0)))), ((length(max(abs(p16) - vec2(0.01, 0.18), 0.0)) + min(max((abs(p16) - vec2(0.01, 0.18)).x, (abs(p16) - vec2(0.01, 0.18)).y), 0.0)) - 0.01)), -(sdBox3(p17, vec3(0.5, 0.5, 0.5)))), max(max(((length(max(abs(p20) - vec2(0.028, 0.118), 0.0)) + min(max((abs(p20) - vec2(0.028, 0.118)).x, (abs(p20) - vec2(0.028, 0.118)).y), 0.0)) - 0.012), -((length(p21) - 0.062))), -(sdBox3(p22, vec3(0.5, 0.5, 0.5))))), max(((length(max(abs(p25) - vec2(0.023, 0.118), 0.0)) + min(max((abs(p25) - vec2(0.023, 0.118)).x, (abs(p25) - vec2(0.023, 0.118)).y), 0.0)) - 0.012), -((length(p26) - 0.062)))), polar31(p28)), max(min(min(((length(max(abs(p35) - vec2(0.013, 0.007), 0.0)) + min(max((abs(p35) - vec2(0.013, 0.007)).x, (abs(p35) - vec2(0.013, 0.007)).y), 0.0)) - 0.005), ((length(max(abs(p37) - vec2(0.013, 0.007), 0.0)) + min(max((abs(p37) - vec2(0.013, 0.007)).x, (abs(p37) - vec2(0.013, 0.007)).y), 0.0)) - 0.005)), ((length(max(abs(p38) - vec2(0.008, 0.056), 0.0)) + min(max((abs(p38) - vec2(0.008, 0.056)).x, (abs(p38) - vec2(0.008, 0.056)).y), 0.0)) - 0.004)), -(polar41(p33)))), min(min((opExtrude(wheel45(p44), p43.z, 0.025) - 0.004), (length(max(abs(p47) - vec2(0.022, 0.05), 0.0)) + min(max((abs(p47) - vec2(0.022, 0.05)).x, (abs(p47) - vec2(0.022, 0.05)).y), 0.0))), (length(p48) - 0.032))), min(min(((length(max(abs(p52) - vec2(0.089, 0.006), 0.0)) + min(max((abs(p52) - vec2(0.089, 0.006)).x, (abs(p52) - vec2(0.089, 0.006)).y), 0.0)) - 0.006), max(opExtrude(wheel56(p55), p54.z, 0.035), (length(p57) - 0.093))), (length(max(abs(p59) - vec2(0.05, 0.1), 0.0)) + min(max((abs(p59) - vec2(0.05, 0.1)).x, (abs(p59) - vec2(0.05, 0.1)).y), 0.0)))), max(min(min(min((length(max(abs(p63) - vec2(0.13, 0.55), 0.0)) + min(max((abs(p63) - vec2(0.13, 0.55)).x, (abs(p63) - vec2(0.13, 0.55)).y), 0.0)), polygon66(p65)), polygon69(p68)), ((length(max(abs(p71) - vec2(0.0225, 0.03), 0.0)) + min(max((abs(p71) - vec2(0.0225, 0.03)).x, (abs(p71) - vec2(0.0225, 0.03)).y), 0.0)) - 0.01)), -(sdBox3(p72, vec3(0.025, 0.15, 0.03))))), (sdBox3(p75, vec3(0.015, 0.067, 0.022)) - 0.008)), max(min(max(max(max((opExtrude(wheel78(p77), p76.z, 0.075) - 0.006), -(opExtrude((abs((length(p80) - 0.285)) - 0.105), p79.z, 0.03))), -(opExtrude((abs((length(p82) - 0.285)) - 0.105), p81.z, 0.03))), -(polar87(p83))), (opExtrude((length(p88) - 0.19), p76.z, 0.11) - 0.01)), -((length(max(abs(p91) - vec2(0.129, 1.5), 0.0)) + min(max((abs(p91) - vec2(0.129, 1.5)).x, (abs(p91) - vec2(0.129, 1.5)).y), 0.0))))), (sdBox3(p92, vec3(0.87, 0.005, 0.62)) - 0.03));
}
