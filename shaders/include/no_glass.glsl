// Replaces glass.glsl and glass_view.glsl in programs that shade no glass: parsing those takes a third of
// the compile time of a plain surface. What is declared here is never used.
layout(binding = UNIT_BACKDROP) uniform sampler2D backdrop;

vec3 shadedGlass(MaterialPoint m, Surface s) {
    return vec3(0.0f);
}
float lightBeforeFarWall(vec3 position, vec3 source, float metres) {
    return 1.0f;
}
