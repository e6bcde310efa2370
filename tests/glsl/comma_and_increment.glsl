float map(vec3 p) { int i = 0; float d = (i++, p.x + float(i)); d += float(i++ + ++i); i += 3, i *= 2; return d + float(i--) - float(--i); }
