#include "lib/solids.glsl"
#include "lib/operators.glsl"
#include "lib/flat.glsl"

float wheel20(vec2 p) {
    float turn = atan(p.y, p.x), sector = 0.20943951;
    turn = abs(turn - sector * round(turn / sector));
    vec2 q = length(p) * vec2(cos(turn), sin(turn)), to, away;
    float d = 1e9, side = 0.0;
    to = q - vec2(0.087922809, 0.0);
    away = to - vec2(0.0, 0.00368505753) * clamp(dot(to, vec2(0.0, 271.366184)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (q.y * 0.087922809 >= q.x * 0.0) side = dot(to, vec2(0.00368505753, 0.0));
    to = q - vec2(0.087922809, 0.00368505753);
    away = to - vec2(-0.0100767242, 0.001212603) * clamp(dot(to, vec2(-97.8220386, 11.7716129)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (q.y * 0.087922809 >= q.x * 0.00368505753) side = dot(to, vec2(0.001212603, 0.0100767242));
    to = q - vec2(0.0778460848, 0.00489766052);
    away = to - vec2(-0.000341421423, 0.00324840785) * clamp(dot(to, vec2(-32.0020915, 304.479562)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (q.y * 0.0778460848 >= q.x * 0.00489766052) side = dot(to, vec2(0.00324840785, 0.000341421423));
    return sign(side) * sqrt(d);
}

float polygon35(vec2 p) {
    vec2 to, away;
    float d = 1e9, side = 1.0;
    to = p - vec2(0.0, -0.035);
    away = to - vec2(0.032, 0.005) * clamp(dot(to, vec2(30.5052431, 4.76644423)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (p.y >= -0.035 && p.y < -0.03 && dot(to, vec2(0.005, -0.032)) < 0.0) side = -side;
    to = p - vec2(0.032, -0.03);
    away = to - vec2(0.008, 0.05) * clamp(dot(to, vec2(3.1201248, 19.50078)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (p.y >= -0.03 && p.y < 0.02 && dot(to, vec2(0.05, -0.008)) < 0.0) side = -side;
    to = p - vec2(0.04, 0.02);
    away = to - vec2(-0.04, 0.01) * clamp(dot(to, vec2(-23.5294118, 5.88235294)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (p.y >= 0.02 && p.y < 0.03 && dot(to, vec2(0.01, 0.04)) < 0.0) side = -side;
    to = p - vec2(0.0, 0.03);
    away = to - vec2(0.0, -0.065) * clamp(dot(to, vec2(0.0, -15.3846154)), 0.0, 1.0);
    d = min(d, dot(away, away));
    if (p.y >= -0.035 && p.y < 0.03 && dot(to, vec2(-0.065, 0.0)) > 0.0) side = -side;
    return side * sqrt(d);
}

float part39(vec3 p) {
    return sdSegment3(p, vec3(0.0, -0.012, 0.0), vec3(0.268, 0.0, 0.0), 0.0045);
}

float polar40(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part39(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part39(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part42(vec3 p) {
    vec3 p41 = mat3(0.939692621, 0.0, 0.342020143, 0.0, 1.0, 0.0, -0.342020143, 0.0, 0.939692621) * p;
    return sdSegment3(p41, vec3(0.0, 0.012, 0.0), vec3(0.268, 0.0, 0.0), 0.0045);
}

float polar43(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part42(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part42(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part48(vec3 p) {
    return sdSegment3(p, vec3(0.0, -0.012, 0.0), vec3(0.268, 0.0, 0.0), 0.0045);
}

float polar49(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part48(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part48(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part51(vec3 p) {
    vec3 p50 = mat3(0.939692621, 0.0, 0.342020143, 0.0, 1.0, 0.0, -0.342020143, 0.0, 0.939692621) * p;
    return sdSegment3(p50, vec3(0.0, 0.012, 0.0), vec3(0.268, 0.0, 0.0), 0.0045);
}

float polar52(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part51(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part51(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part96(vec3 p) {
    vec3 p86 = p - vec3(0.332, 0.105, 0.0);
    vec3 p87 = p - vec3(-0.09, -0.215, 0.0);
    vec3 p88 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p87;
    vec2 p89 = vec2(length(p88.xz) - 0.0, p88.y);
    vec3 p90 = p - vec3(-0.47, -0.2, 0.0);
    vec3 p91 = mat3(0.991444861, -0.130526192, 0.0, 0.130526192, 0.991444861, 0.0, 0.0, 0.0, 1.0) * p90;
    vec2 p92 = p91.xy;
    vec3 p93 = p - vec3(0.47, -0.2, 0.0);
    vec3 p94 = mat3(0.953716951, -0.3007058, 0.0, 0.3007058, 0.953716951, 0.0, 0.0, 0.0, 1.0) * p93;
    vec2 p95 = p94.xy;
    return min(min(min(min(min(min(min(opSmoothUnion(sdSegment3(p, vec3(-0.09, -0.215, 0.0), vec3(-0.205, 0.2, 0.0), 0.018), sdSegment3(p, vec3(-0.182, 0.117, 0.0), vec3(0.292, 0.22375, 0.0), 0.0165), 0.02), sdSegment3(p, vec3(-0.09, -0.215, 0.0), vec3(0.316, 0.14875, 0.0), 0.02)), sdSegment3(p, vec3(0.322, 0.13, 0.0), vec3(0.282, 0.255, 0.0), 0.0245)), (sdBox3(p86, vec3(0.0105, 0.003, 0.0455)) - 0.012)), (length(max(abs(p89) - vec2(0.032, 0.0375), 0.0)) + min(max((abs(p89) - vec2(0.032, 0.0375)).x, (abs(p89) - vec2(0.032, 0.0375)).y), 0.0))), min(min(min(sdSegment3(p, vec3(-0.1843, 0.1253, -0.012), vec3(-0.47, -0.2, -0.052), 0.0105), sdSegment3(p, vec3(-0.09, -0.215, -0.02), vec3(-0.47, -0.2, -0.052), 0.0115)), sdSegment3(p, vec3(0.334, 0.1, -0.042), vec3(0.47, -0.2, -0.05), 0.0125)), min(min(sdSegment3(p, vec3(-0.1843, 0.1253, 0.012), vec3(-0.47, -0.2, 0.052), 0.0105), sdSegment3(p, vec3(-0.09, -0.215, 0.02), vec3(-0.47, -0.2, 0.052), 0.0115)), sdSegment3(p, vec3(0.334, 0.1, 0.042), vec3(0.47, -0.2, 0.05), 0.0125)))), (opExtrude(sdArc(p92, vec2(0.953716951, 0.3007058), 0.345, 0.007), p91.z, 0.031) - 0.003)), (opExtrude(sdArc(p95, vec2(0.923879533, 0.382683432), 0.345, 0.007), p94.z, 0.031) - 0.003));
}

float part103(vec3 p) {
    vec3 p97 = p - vec3(-0.47, -0.2, 0.0);
    vec3 p98 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p97;
    vec2 p99 = vec2(length(p98.xz) - 0.3, p98.y);
    vec3 p100 = p - vec3(0.47, -0.2, 0.0);
    vec3 p101 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p100;
    vec2 p102 = vec2(length(p101.xz) - 0.3, p101.y);
    return min((length(p99) - 0.024), (length(p102) - 0.024));
}

float part124(vec3 p) {
    return sdSegment3(p, vec3(0.0, -0.012, 0.0), vec3(0.268, 0.0, 0.0), 0.0045);
}

float polar125(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part124(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part124(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part127(vec3 p) {
    vec3 p126 = mat3(0.939692621, 0.0, 0.342020143, 0.0, 1.0, 0.0, -0.342020143, 0.0, 0.939692621) * p;
    return sdSegment3(p126, vec3(0.0, 0.012, 0.0), vec3(0.268, 0.0, 0.0), 0.0045);
}

float polar128(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part127(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part127(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part133(vec3 p) {
    return sdSegment3(p, vec3(0.0, -0.012, 0.0), vec3(0.268, 0.0, 0.0), 0.0045);
}

float polar134(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part133(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part133(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part136(vec3 p) {
    vec3 p135 = mat3(0.939692621, 0.0, 0.342020143, 0.0, 1.0, 0.0, -0.342020143, 0.0, 0.939692621) * p;
    return sdSegment3(p135, vec3(0.0, 0.012, 0.0), vec3(0.268, 0.0, 0.0), 0.0045);
}

float polar137(vec3 p) {
    float home = round(atan(p.z, p.x) * 1.43239449) * 0.698131701;
    float c = cos(home), s = sin(home);
    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    float d = part136(q);
    for (int i = 0; i < 2; i++) {
        float k = 0.766044443, h = i == 0 ? 0.64278761 : -0.64278761;
        d = min(d, part136(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));
    }
    return d;
}

float part139(vec3 p) {
    vec3 p104 = p - vec3(0.292, 0.38, -0.08);
    vec3 p105 = p - vec3(-0.09, -0.215, 0.055);
    vec2 p106 = p105.xy;
    vec2 p107 = p105.xy;
    vec3 p108 = mat3(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0) * p105;
    vec3 p109 = p108 - vec3(0.0, 0.042, 0.0);
    vec3 p110 = mat3(0.309016994, -0.951056516, 0.0, 0.951056516, 0.309016994, 0.0, 0.0, 0.0, 1.0) * p105;
    vec3 p111 = p110 - vec3(0.0, 0.042, 0.0);
    vec3 p112 = mat3(-0.809016994, -0.587785252, 0.0, 0.587785252, -0.809016994, 0.0, 0.0, 0.0, 1.0) * p105;
    vec3 p113 = p112 - vec3(0.0, 0.042, 0.0);
    vec3 p114 = mat3(-0.809016994, 0.587785252, 0.0, -0.587785252, -0.809016994, 0.0, 0.0, 0.0, 1.0) * p105;
    vec3 p115 = p114 - vec3(0.0, 0.042, 0.0);
    vec3 p116 = mat3(0.309016994, 0.951056516, 0.0, -0.951056516, 0.309016994, 0.0, 0.0, 0.0, 1.0) * p105;
    vec3 p117 = p116 - vec3(0.0, 0.042, 0.0);
    vec3 p118 = p - vec3(0.385, 0.19, 0.0);
    vec3 p119 = mat3(1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16, 0.0, 0.0, 0.0, 1.0) * p118;
    vec2 p120 = vec2(length(p119.xz) - 0.0, p119.y);
    vec3 p121 = p - vec3(-0.47, -0.2, 0.0);
    vec3 p122 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p121;
    vec2 p123 = vec2(length(p122.xz) - 0.268, p122.y);
    vec2 p129 = vec2(length(p122.xz) - 0.0, p122.y);
    vec3 p130 = p - vec3(0.47, -0.2, 0.0);
    vec3 p131 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p130;
    vec2 p132 = vec2(length(p131.xz) - 0.268, p131.y);
    vec2 p138 = vec2(length(p131.xz) - 0.0, p131.y);
    return min(min(min(min(min(min(min(min(min(min(min(min(min(min(sdSegment3(p, vec3(0.282, 0.255, 0.0), vec3(0.262, 0.325, 0.0), 0.014), sdSegment3(p, vec3(0.262, 0.325, 0.0), vec3(0.317, 0.355, -0.12), 0.0125)), sdSegment3(p, vec3(0.262, 0.325, 0.0), vec3(0.317, 0.355, 0.12), 0.0125)), sdSegment3(p, vec3(0.317, 0.355, -0.12), vec3(0.222, 0.36, -0.215), 0.0125)), sdSegment3(p, vec3(0.317, 0.355, 0.12), vec3(0.222, 0.36, 0.215), 0.0125)), sdSegment3(p, vec3(0.332, 0.345, -0.125), vec3(0.252, 0.337, -0.215), 0.006)), sdSegment3(p, vec3(0.332, 0.345, 0.125), vec3(0.252, 0.337, 0.215), 0.006)), sdEllipsoidBound(p104, vec3(0.0275, 0.0175, 0.0275))), min(sdSegment3(p, vec3(-0.205, 0.2, 0.0), vec3(-0.223, 0.26, 0.0), 0.0125), sdSegment3(p, vec3(-0.265, 0.262, 0.0), vec3(-0.175, 0.262, 0.0), 0.009))), min(min(min(min(min(max(opExtrude(wheel20(p106), p105.z, 0.004), -(opExtrude((abs((length(p107) - 0.052)) - 0.017), p105.z, 0.05))), sdBox3(p109, vec3(0.006, 0.045, 0.004))), sdBox3(p111, vec3(0.006, 0.045, 0.004))), sdBox3(p113, vec3(0.006, 0.045, 0.004))), sdBox3(p115, vec3(0.006, 0.045, 0.004))), sdBox3(p117, vec3(0.006, 0.045, 0.004)))), min(min(sdSegment3(p, vec3(-0.09, -0.215, -0.07), vec3(-0.09, -0.215, 0.075), 0.012), sdSegment3(p, vec3(-0.09, -0.215, -0.075), vec3(-0.208, -0.14, -0.085), 0.011)), sdSegment3(p, vec3(-0.09, -0.215, 0.075), vec3(0.028, -0.29, 0.085), 0.011))), min(min(sdSegment3(p, vec3(-0.27, -0.24, 0.03), vec3(-0.2, -0.512, 0.15), 0.011), sdSegment3(p, vec3(-0.2, -0.512, 0.15), vec3(-0.235, -0.512, 0.17), 0.011)), sdSegment3(p, vec3(-0.31, -0.222, 0.0), vec3(-0.27, -0.24, 0.03), 0.016))), min(polygon35(p120), sdSegment3(p, vec3(0.282, 0.215, 0.0), vec3(0.37, 0.19, 0.0), 0.008))), min(min(min(min(min(((length(max(abs(p123) - vec2(0.003, 0.01), 0.0)) + min(max((abs(p123) - vec2(0.003, 0.01)).x, (abs(p123) - vec2(0.003, 0.01)).y), 0.0)) - 0.006), polar125(p122)), polar128(p122)), (length(max(abs(p129) - vec2(0.022, 0.035), 0.0)) + min(max((abs(p129) - vec2(0.022, 0.035)).x, (abs(p129) - vec2(0.022, 0.035)).y), 0.0))), sdSegment3(p122, vec3(0.0, -0.062, 0.0), vec3(0.0, 0.062, 0.0), 0.009)), min(min(min(min(((length(max(abs(p132) - vec2(0.003, 0.01), 0.0)) + min(max((abs(p132) - vec2(0.003, 0.01)).x, (abs(p132) - vec2(0.003, 0.01)).y), 0.0)) - 0.006), polar134(p131)), polar137(p131)), (length(max(abs(p138) - vec2(0.022, 0.035), 0.0)) + min(max((abs(p138) - vec2(0.022, 0.035)).x, (abs(p138) - vec2(0.022, 0.035)).y), 0.0))), sdSegment3(p131, vec3(0.0, -0.062, 0.0), vec3(0.0, 0.062, 0.0), 0.009)))), sdSegment3(p, vec3(0.3, 0.22, 0.0), vec3(0.4, 0.175, 0.0), 0.01));
}

float part143(vec3 p) {
    vec3 p140 = p - vec3(-0.47, -0.2, 0.055);
    vec3 p141 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p140;
    vec2 p142 = vec2(length(p141.xz) - 0.032, p141.y);
    return min(min(sdSegment3(p, vec3(-0.09, -0.133, 0.055), vec3(-0.47, -0.168, 0.055), 0.006), sdSegment3(p, vec3(-0.09, -0.297, 0.055), vec3(-0.47, -0.232, 0.055), 0.006)), (length(p142) - 0.007));
}

float part149(vec3 p) {
    vec3 p144 = p - vec3(-0.223, 0.283, 0.0);
    vec3 p145 = p144 - vec3(-0.05, 0.0, 0.0);
    vec3 p146 = p144 - vec3(0.0, -0.066, 0.0);
    vec3 p147 = p - vec3(-0.208, -0.14, -0.135);
    vec3 p148 = p - vec3(0.028, -0.29, 0.135);
    return min(min(max(opSmoothUnion(sdEllipsoidBound(p145, vec3(0.075, 0.025, 0.0775)), sdSegment3(p144, vec3(0.12, 0.004, 0.0), vec3(-0.05, 0.0, 0.0), 0.02), 0.06), -(sdBox3(p146, vec3(0.25, 0.05, 0.25)))), min(sdSegment3(p, vec3(0.262, 0.3583, -0.175), vec3(0.212, 0.3602, -0.225), 0.019), sdSegment3(p, vec3(0.262, 0.3583, 0.175), vec3(0.212, 0.3602, 0.225), 0.019))), min((sdBox3(p147, vec3(0.034, 0.005, 0.0315)) - 0.006), (sdBox3(p148, vec3(0.034, 0.005, 0.0315)) - 0.006)));
}

float part172(vec3 p) {
    vec3 p150 = p - vec3(0.47, 0.245, 0.0);
    vec3 p151 = p150 - vec3(0.0, -0.068, 0.0);
    vec3 p152 = p151 / 0.88;
    vec3 p153 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p152;
    vec2 p154 = p153.xy;
    vec3 p155 = p150 - vec3(0.0, -0.034, 0.0);
    vec3 p156 = p155 / 0.91;
    vec3 p157 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p156;
    vec2 p158 = p157.xy;
    vec3 p159 = p150 - vec3(0.0, 0.0, 0.0);
    vec3 p160 = p159 / 0.94;
    vec3 p161 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p160;
    vec2 p162 = p161.xy;
    vec3 p163 = p150 - vec3(0.0, 0.034, 0.0);
    vec3 p164 = p163 / 0.97;
    vec3 p165 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p164;
    vec2 p166 = p165.xy;
    vec3 p167 = p150 - vec3(0.0, 0.068, 0.0);
    vec3 p168 = p167 / 1.0;
    vec3 p169 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p168;
    vec2 p170 = p169.xy;
    vec3 p171 = p150 - vec3(0.0, -0.075, 0.0);
    return min(min(min(min(min(min(min(min(min(min(min(min(min(min(min(min(min((opExtrude((abs(((length(max(abs(p154) - vec2(0.0575, 0.075), 0.0)) + min(max((abs(p154) - vec2(0.0575, 0.075)).x, (abs(p154) - vec2(0.0575, 0.075)).y), 0.0)) - 0.05)) - 0.006), p153.z, 0.011) * 0.88), (opExtrude((abs(((length(max(abs(p158) - vec2(0.0575, 0.075), 0.0)) + min(max((abs(p158) - vec2(0.0575, 0.075)).x, (abs(p158) - vec2(0.0575, 0.075)).y), 0.0)) - 0.05)) - 0.006), p157.z, 0.011) * 0.91)), (opExtrude((abs(((length(max(abs(p162) - vec2(0.0575, 0.075), 0.0)) + min(max((abs(p162) - vec2(0.0575, 0.075)).x, (abs(p162) - vec2(0.0575, 0.075)).y), 0.0)) - 0.05)) - 0.006), p161.z, 0.011) * 0.94)), (opExtrude((abs(((length(max(abs(p166) - vec2(0.0575, 0.075), 0.0)) + min(max((abs(p166) - vec2(0.0575, 0.075)).x, (abs(p166) - vec2(0.0575, 0.075)).y), 0.0)) - 0.05)) - 0.006), p165.z, 0.011) * 0.97)), (opExtrude((abs(((length(max(abs(p170) - vec2(0.0575, 0.075), 0.0)) + min(max((abs(p170) - vec2(0.0575, 0.075)).x, (abs(p170) - vec2(0.0575, 0.075)).y), 0.0)) - 0.05)) - 0.006), p169.z, 0.011) * 1.0)), sdSegment3(p150, vec3(-0.09568, -0.07, -0.069), vec3(-0.10712, 0.072, -0.07725), 0.006)), sdSegment3(p150, vec3(-0.09568, -0.07, 0.0), vec3(-0.10712, 0.072, 0.0), 0.006)), sdSegment3(p150, vec3(-0.09568, -0.07, 0.069), vec3(-0.10712, 0.072, 0.07725), 0.006)), sdSegment3(p150, vec3(0.09568, -0.07, -0.069), vec3(0.10712, 0.072, -0.07725), 0.006)), sdSegment3(p150, vec3(0.09568, -0.07, 0.0), vec3(0.10712, 0.072, 0.0), 0.006)), sdSegment3(p150, vec3(0.09568, -0.07, 0.069), vec3(0.10712, 0.072, 0.07725), 0.006)), sdSegment3(p150, vec3(-0.0552, -0.07, -0.11224), vec3(-0.0618, 0.072, -0.12566), 0.006)), sdSegment3(p150, vec3(0.0, -0.07, -0.11224), vec3(0.0, 0.072, -0.12566), 0.006)), sdSegment3(p150, vec3(0.0552, -0.07, -0.11224), vec3(0.0618, 0.072, -0.12566), 0.006)), sdSegment3(p150, vec3(-0.0552, -0.07, 0.11224), vec3(-0.0618, 0.072, 0.12566), 0.006)), sdSegment3(p150, vec3(0.0, -0.07, 0.11224), vec3(0.0, 0.072, 0.12566), 0.006)), sdSegment3(p150, vec3(0.0552, -0.07, 0.11224), vec3(0.0618, 0.072, 0.12566), 0.006)), (sdBox3(p171, vec3(0.084, 0.001, 0.099)) - 0.006));
}

float part175(vec3 p) {
    vec3 p173 = p - vec3(0.0, -0.549, 0.0);
    vec2 p174 = vec2(length(p173.xz) - 0.0, p173.y);
    return ((length(max(abs(p174) - vec2(0.82, 0.005), 0.0)) + min(max((abs(p174) - vec2(0.82, 0.005)).x, (abs(p174) - vec2(0.82, 0.005)).y), 0.0)) - 0.02);
}

vec3 albedo(vec3 p, vec3 n) {
    float nearest = 1e9, d;
    vec3 colour = vec3(0.5);
    d = part96(p);
    if (d < nearest) { nearest = d; colour = vec3(0.045, 0.23, 0.2); }
    d = part103(p);
    if (d < nearest) { nearest = d; colour = vec3(0.035, 0.035, 0.038); }
    d = part139(p);
    if (d < nearest) { nearest = d; colour = vec3(0.55, 0.56, 0.58); }
    d = part143(p);
    if (d < nearest) { nearest = d; colour = vec3(0.16, 0.14, 0.12); }
    d = part149(p);
    if (d < nearest) { nearest = d; colour = vec3(0.3, 0.12, 0.045); }
    d = part172(p);
    if (d < nearest) { nearest = d; colour = vec3(0.55, 0.36, 0.16); }
    d = part175(p);
    if (d < nearest) { nearest = d; colour = vec3(0.44, 0.42, 0.38); }
    return colour;
}

float sdf(vec3 p) {
    vec3 p1 = p - vec3(-0.47, -0.2, 0.0);
    vec3 p2 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p1;
    vec2 p3 = vec2(length(p2.xz) - 0.3, p2.y);
    vec3 p4 = p - vec3(0.47, -0.2, 0.0);
    vec3 p5 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p4;
    vec2 p6 = vec2(length(p5.xz) - 0.3, p5.y);
    vec3 p7 = p - vec3(0.332, 0.105, 0.0);
    vec3 p8 = p - vec3(-0.09, -0.215, 0.0);
    vec3 p9 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p8;
    vec2 p10 = vec2(length(p9.xz) - 0.0, p9.y);
    vec3 p11 = p - vec3(-0.47, -0.2, 0.0);
    vec3 p12 = mat3(0.991444861, -0.130526192, 0.0, 0.130526192, 0.991444861, 0.0, 0.0, 0.0, 1.0) * p11;
    vec2 p13 = p12.xy;
    vec3 p14 = p - vec3(0.47, -0.2, 0.0);
    vec3 p15 = mat3(0.953716951, -0.3007058, 0.0, 0.3007058, 0.953716951, 0.0, 0.0, 0.0, 1.0) * p14;
    vec2 p16 = p15.xy;
    vec3 p17 = p - vec3(0.292, 0.38, -0.08);
    vec3 p18 = p - vec3(-0.09, -0.215, 0.055);
    vec2 p19 = p18.xy;
    vec2 p21 = p18.xy;
    vec3 p22 = mat3(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0) * p18;
    vec3 p23 = p22 - vec3(0.0, 0.042, 0.0);
    vec3 p24 = mat3(0.309016994, -0.951056516, 0.0, 0.951056516, 0.309016994, 0.0, 0.0, 0.0, 1.0) * p18;
    vec3 p25 = p24 - vec3(0.0, 0.042, 0.0);
    vec3 p26 = mat3(-0.809016994, -0.587785252, 0.0, 0.587785252, -0.809016994, 0.0, 0.0, 0.0, 1.0) * p18;
    vec3 p27 = p26 - vec3(0.0, 0.042, 0.0);
    vec3 p28 = mat3(-0.809016994, 0.587785252, 0.0, -0.587785252, -0.809016994, 0.0, 0.0, 0.0, 1.0) * p18;
    vec3 p29 = p28 - vec3(0.0, 0.042, 0.0);
    vec3 p30 = mat3(0.309016994, 0.951056516, 0.0, -0.951056516, 0.309016994, 0.0, 0.0, 0.0, 1.0) * p18;
    vec3 p31 = p30 - vec3(0.0, 0.042, 0.0);
    vec3 p32 = p - vec3(0.385, 0.19, 0.0);
    vec3 p33 = mat3(1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16, 0.0, 0.0, 0.0, 1.0) * p32;
    vec2 p34 = vec2(length(p33.xz) - 0.0, p33.y);
    vec3 p36 = p - vec3(-0.47, -0.2, 0.0);
    vec3 p37 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p36;
    vec2 p38 = vec2(length(p37.xz) - 0.268, p37.y);
    vec2 p44 = vec2(length(p37.xz) - 0.0, p37.y);
    vec3 p45 = p - vec3(0.47, -0.2, 0.0);
    vec3 p46 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p45;
    vec2 p47 = vec2(length(p46.xz) - 0.268, p46.y);
    vec2 p53 = vec2(length(p46.xz) - 0.0, p46.y);
    vec3 p54 = p - vec3(-0.47, -0.2, 0.055);
    vec3 p55 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, -1.0, 0.0, 1.0, 1.11022302e-16) * p54;
    vec2 p56 = vec2(length(p55.xz) - 0.032, p55.y);
    vec3 p57 = p - vec3(-0.223, 0.283, 0.0);
    vec3 p58 = p57 - vec3(-0.05, 0.0, 0.0);
    vec3 p59 = p57 - vec3(0.0, -0.066, 0.0);
    vec3 p60 = p - vec3(-0.208, -0.14, -0.135);
    vec3 p61 = p - vec3(0.028, -0.29, 0.135);
    vec3 p62 = p - vec3(0.47, 0.245, 0.0);
    vec3 p63 = p62 - vec3(0.0, -0.068, 0.0);
    vec3 p64 = p63 / 0.88;
    vec3 p65 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p64;
    vec2 p66 = p65.xy;
    vec3 p67 = p62 - vec3(0.0, -0.034, 0.0);
    vec3 p68 = p67 / 0.91;
    vec3 p69 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p68;
    vec2 p70 = p69.xy;
    vec3 p71 = p62 - vec3(0.0, 0.0, 0.0);
    vec3 p72 = p71 / 0.94;
    vec3 p73 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p72;
    vec2 p74 = p73.xy;
    vec3 p75 = p62 - vec3(0.0, 0.034, 0.0);
    vec3 p76 = p75 / 0.97;
    vec3 p77 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p76;
    vec2 p78 = p77.xy;
    vec3 p79 = p62 - vec3(0.0, 0.068, 0.0);
    vec3 p80 = p79 / 1.0;
    vec3 p81 = mat3(1.0, 0.0, 0.0, 0.0, 1.11022302e-16, 1.0, 0.0, -1.0, 1.11022302e-16) * p80;
    vec2 p82 = p81.xy;
    vec3 p83 = p62 - vec3(0.0, -0.075, 0.0);
    vec3 p84 = p - vec3(0.0, -0.549, 0.0);
    vec2 p85 = vec2(length(p84.xz) - 0.0, p84.y);
    return min(min(min(min(min(min(min(min((length(p3) - 0.024), (length(p6) - 0.024)), min(min(min(min(min(min(min(opSmoothUnion(sdSegment3(p, vec3(-0.09, -0.215, 0.0), vec3(-0.205, 0.2, 0.0), 0.018), sdSegment3(p, vec3(-0.182, 0.117, 0.0), vec3(0.292, 0.22375, 0.0), 0.0165), 0.02), sdSegment3(p, vec3(-0.09, -0.215, 0.0), vec3(0.316, 0.14875, 0.0), 0.02)), sdSegment3(p, vec3(0.322, 0.13, 0.0), vec3(0.282, 0.255, 0.0), 0.0245)), (sdBox3(p7, vec3(0.0105, 0.003, 0.0455)) - 0.012)), (length(max(abs(p10) - vec2(0.032, 0.0375), 0.0)) + min(max((abs(p10) - vec2(0.032, 0.0375)).x, (abs(p10) - vec2(0.032, 0.0375)).y), 0.0))), min(min(min(sdSegment3(p, vec3(-0.1843, 0.1253, -0.012), vec3(-0.47, -0.2, -0.052), 0.0105), sdSegment3(p, vec3(-0.09, -0.215, -0.02), vec3(-0.47, -0.2, -0.052), 0.0115)), sdSegment3(p, vec3(0.334, 0.1, -0.042), vec3(0.47, -0.2, -0.05), 0.0125)), min(min(sdSegment3(p, vec3(-0.1843, 0.1253, 0.012), vec3(-0.47, -0.2, 0.052), 0.0105), sdSegment3(p, vec3(-0.09, -0.215, 0.02), vec3(-0.47, -0.2, 0.052), 0.0115)), sdSegment3(p, vec3(0.334, 0.1, 0.042), vec3(0.47, -0.2, 0.05), 0.0125)))), (opExtrude(sdArc(p13, vec2(0.953716951, 0.3007058), 0.345, 0.007), p12.z, 0.031) - 0.003)), (opExtrude(sdArc(p16, vec2(0.923879533, 0.382683432), 0.345, 0.007), p15.z, 0.031) - 0.003))), min(min(min(min(min(min(min(min(min(min(min(min(min(sdSegment3(p, vec3(0.282, 0.255, 0.0), vec3(0.262, 0.325, 0.0), 0.014), sdSegment3(p, vec3(0.262, 0.325, 0.0), vec3(0.317, 0.355, -0.12), 0.0125)), sdSegment3(p, vec3(0.262, 0.325, 0.0), vec3(0.317, 0.355, 0.12), 0.0125)), sdSegment3(p, vec3(0.317, 0.355, -0.12), vec3(0.222, 0.36, -0.215), 0.0125)), sdSegment3(p, vec3(0.317, 0.355, 0.12), vec3(0.222, 0.36, 0.215), 0.0125)), sdSegment3(p, vec3(0.332, 0.345, -0.125), vec3(0.252, 0.337, -0.215), 0.006)), sdSegment3(p, vec3(0.332, 0.345, 0.125), vec3(0.252, 0.337, 0.215), 0.006)), sdEllipsoidBound(p17, vec3(0.0275, 0.0175, 0.0275))), min(sdSegment3(p, vec3(-0.205, 0.2, 0.0), vec3(-0.223, 0.26, 0.0), 0.0125), sdSegment3(p, vec3(-0.265, 0.262, 0.0), vec3(-0.175, 0.262, 0.0), 0.009))), min(min(min(min(min(max(opExtrude(wheel20(p19), p18.z, 0.004), -(opExtrude((abs((length(p21) - 0.052)) - 0.017), p18.z, 0.05))), sdBox3(p23, vec3(0.006, 0.045, 0.004))), sdBox3(p25, vec3(0.006, 0.045, 0.004))), sdBox3(p27, vec3(0.006, 0.045, 0.004))), sdBox3(p29, vec3(0.006, 0.045, 0.004))), sdBox3(p31, vec3(0.006, 0.045, 0.004)))), min(min(sdSegment3(p, vec3(-0.09, -0.215, -0.07), vec3(-0.09, -0.215, 0.075), 0.012), sdSegment3(p, vec3(-0.09, -0.215, -0.075), vec3(-0.208, -0.14, -0.085), 0.011)), sdSegment3(p, vec3(-0.09, -0.215, 0.075), vec3(0.028, -0.29, 0.085), 0.011))), min(min(sdSegment3(p, vec3(-0.27, -0.24, 0.03), vec3(-0.2, -0.512, 0.15), 0.011), sdSegment3(p, vec3(-0.2, -0.512, 0.15), vec3(-0.235, -0.512, 0.17), 0.011)), sdSegment3(p, vec3(-0.31, -0.222, 0.0), vec3(-0.27, -0.24, 0.03), 0.016))), min(polygon35(p34), sdSegment3(p, vec3(0.282, 0.215, 0.0), vec3(0.37, 0.19, 0.0), 0.008))), min(min(min(min(min(((length(max(abs(p38) - vec2(0.003, 0.01), 0.0)) + min(max((abs(p38) - vec2(0.003, 0.01)).x, (abs(p38) - vec2(0.003, 0.01)).y), 0.0)) - 0.006), polar40(p37)), polar43(p37)), (length(max(abs(p44) - vec2(0.022, 0.035), 0.0)) + min(max((abs(p44) - vec2(0.022, 0.035)).x, (abs(p44) - vec2(0.022, 0.035)).y), 0.0))), sdSegment3(p37, vec3(0.0, -0.062, 0.0), vec3(0.0, 0.062, 0.0), 0.009)), min(min(min(min(((length(max(abs(p47) - vec2(0.003, 0.01), 0.0)) + min(max((abs(p47) - vec2(0.003, 0.01)).x, (abs(p47) - vec2(0.003, 0.01)).y), 0.0)) - 0.006), polar49(p46)), polar52(p46)), (length(max(abs(p53) - vec2(0.022, 0.035), 0.0)) + min(max((abs(p53) - vec2(0.022, 0.035)).x, (abs(p53) - vec2(0.022, 0.035)).y), 0.0))), sdSegment3(p46, vec3(0.0, -0.062, 0.0), vec3(0.0, 0.062, 0.0), 0.009))))), min(min(sdSegment3(p, vec3(-0.09, -0.133, 0.055), vec3(-0.47, -0.168, 0.055), 0.006), sdSegment3(p, vec3(-0.09, -0.297, 0.055), vec3(-0.47, -0.232, 0.055), 0.006)), (length(p56) - 0.007))), min(min(max(opSmoothUnion(sdEllipsoidBound(p58, vec3(0.075, 0.025, 0.0775)), sdSegment3(p57, vec3(0.12, 0.004, 0.0), vec3(-0.05, 0.0, 0.0), 0.02), 0.06), -(sdBox3(p59, vec3(0.25, 0.05, 0.25)))), min(sdSegment3(p, vec3(0.262, 0.3583, -0.175), vec3(0.212, 0.3602, -0.225), 0.019), sdSegment3(p, vec3(0.262, 0.3583, 0.175), vec3(0.212, 0.3602, 0.225), 0.019))), min((sdBox3(p60, vec3(0.034, 0.005, 0.0315)) - 0.006), (sdBox3(p61, vec3(0.034, 0.005, 0.0315)) - 0.006)))), min(min(min(min(min(min(min(min(min(min(min(min(min(min(min(min(min((opExtrude((abs(((length(max(abs(p66) - vec2(0.0575, 0.075), 0.0)) + min(max((abs(p66) - vec2(0.0575, 0.075)).x, (abs(p66) - vec2(0.0575, 0.075)).y), 0.0)) - 0.05)) - 0.006), p65.z, 0.011) * 0.88), (opExtrude((abs(((length(max(abs(p70) - vec2(0.0575, 0.075), 0.0)) + min(max((abs(p70) - vec2(0.0575, 0.075)).x, (abs(p70) - vec2(0.0575, 0.075)).y), 0.0)) - 0.05)) - 0.006), p69.z, 0.011) * 0.91)), (opExtrude((abs(((length(max(abs(p74) - vec2(0.0575, 0.075), 0.0)) + min(max((abs(p74) - vec2(0.0575, 0.075)).x, (abs(p74) - vec2(0.0575, 0.075)).y), 0.0)) - 0.05)) - 0.006), p73.z, 0.011) * 0.94)), (opExtrude((abs(((length(max(abs(p78) - vec2(0.0575, 0.075), 0.0)) + min(max((abs(p78) - vec2(0.0575, 0.075)).x, (abs(p78) - vec2(0.0575, 0.075)).y), 0.0)) - 0.05)) - 0.006), p77.z, 0.011) * 0.97)), (opExtrude((abs(((length(max(abs(p82) - vec2(0.0575, 0.075), 0.0)) + min(max((abs(p82) - vec2(0.0575, 0.075)).x, (abs(p82) - vec2(0.0575, 0.075)).y), 0.0)) - 0.05)) - 0.006), p81.z, 0.011) * 1.0)), sdSegment3(p62, vec3(-0.09568, -0.07, -0.069), vec3(-0.10712, 0.072, -0.07725), 0.006)), sdSegment3(p62, vec3(-0.09568, -0.07, 0.0), vec3(-0.10712, 0.072, 0.0), 0.006)), sdSegment3(p62, vec3(-0.09568, -0.07, 0.069), vec3(-0.10712, 0.072, 0.07725), 0.006)), sdSegment3(p62, vec3(0.09568, -0.07, -0.069), vec3(0.10712, 0.072, -0.07725), 0.006)), sdSegment3(p62, vec3(0.09568, -0.07, 0.0), vec3(0.10712, 0.072, 0.0), 0.006)), sdSegment3(p62, vec3(0.09568, -0.07, 0.069), vec3(0.10712, 0.072, 0.07725), 0.006)), sdSegment3(p62, vec3(-0.0552, -0.07, -0.11224), vec3(-0.0618, 0.072, -0.12566), 0.006)), sdSegment3(p62, vec3(0.0, -0.07, -0.11224), vec3(0.0, 0.072, -0.12566), 0.006)), sdSegment3(p62, vec3(0.0552, -0.07, -0.11224), vec3(0.0618, 0.072, -0.12566), 0.006)), sdSegment3(p62, vec3(-0.0552, -0.07, 0.11224), vec3(-0.0618, 0.072, 0.12566), 0.006)), sdSegment3(p62, vec3(0.0, -0.07, 0.11224), vec3(0.0, 0.072, 0.12566), 0.006)), sdSegment3(p62, vec3(0.0552, -0.07, 0.11224), vec3(0.0618, 0.072, 0.12566), 0.006)), (sdBox3(p83, vec3(0.084, 0.001, 0.099)) - 0.006))), sdSegment3(p, vec3(0.3, 0.22, 0.0), vec3(0.4, 0.175, 0.0), 0.01)), ((length(max(abs(p85) - vec2(0.82, 0.005), 0.0)) + min(max((abs(p85) - vec2(0.82, 0.005)).x, (abs(p85) - vec2(0.82, 0.005)).y), 0.0)) - 0.02));
}
