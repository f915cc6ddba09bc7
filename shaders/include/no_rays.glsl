// In the place of ray_start.glsl where a variant follows no rays: parsing those
// takes longer than everything else in a plain surface. What is declared here is never called.
vec3 tracedReflection(Surface s, vec3 position) {
    return vec3(0.0f);
}
struct GlassRays {
    vec3 mirrored;
    vec3 through;
};
GlassRays tracedThrough(Surface s, vec3 position, vec3 aside, vec3 inside, float lobe) {
    return GlassRays(vec3(0.0f), vec3(0.0f));
}
void weighRays(vec3 mirrored, vec3 through) {
}
vec3 finishRays(float coverage) {
    return vec3(0.0f);
}
