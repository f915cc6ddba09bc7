// Values of light at vertices; only views with VIEW_SURFACE_LIGHT read it. With VIEW_EMITTERS one more
// row follows those of each value.
layout(binding = UNIT_SURFACE_LIGHT) uniform usamplerBuffer surfaceLight;

uvec4 surfaceLightRow(int value, int row) {
    int rows = viewHas(VIEW_EMITTERS) ? SURFACE_LIGHT_ROWS + 1 : SURFACE_LIGHT_ROWS;
    return texelFetch(surfaceLight, rows * value + row);
}
