// What the surface programs hand from vertices to pixels. VARYING is in or out. What a variant does
// not read, the linker removes.

VARYING vec3 positionEye;
VARYING vec3 vertexNormal;
VARYING vec4 vertexTangent;  // w: sign of the bitangent
VARYING vec2 texCoord0;
VARYING vec2 texCoord1;
VARYING vec4 vertexColor;
flat VARYING float modelScale;  // metres for each unit of the mesh's space
flat VARYING vec3 drawNumbers;  // first light, number of lights, object id or what it is seen as

bool has(uint feature) {
    return (FEATURES & feature) != 0u;
}
