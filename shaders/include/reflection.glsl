// What a surface mirrors. Every way of finding out, one feature bit each, stands here and nowhere
// else; the default is the environment map, prefiltered by roughness.

vec3 reflectedRadiance(Surface s, vec3 position) {
    vec3 mirrored = reflect(-s.toEye, s.normal);
    return environmentRadiance(mirrored, s.roughness);
}
