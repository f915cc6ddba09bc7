// Varyings of the surface programs. VARYING is in or out. The linker removes those that a variant does
// not read.

VARYING vec3 positionEye;
VARYING vec3 vertexNormal;
VARYING vec4 vertexTangent;  // w: sign of the bitangent
VARYING vec2 texCoord0;
VARYING vec2 texCoord1;
VARYING vec4 vertexColor;
// If VIEW_SURFACE_LIGHT:
VARYING vec3 lightIrradiance;
VARYING vec4 lightTurned;
VARYING vec4 lightVisible;
VARYING vec3 lightNearby;
VARYING vec2 lightSides;
flat VARYING float modelScale;  // metres for each unit of the mesh's space
// First light; number of lights, with a half added if the mesh has no colours; object id or what it
// is seen as.
flat VARYING vec3 drawNumbers;

// With several samples per pixel, the pixel's centre may lie outside of the triangle, and in front of
// the body in which rays must start. Such surfaces use direction of view and normal of a covered sample.
const uint FEATURES_OF_RAYS = FEATURE_TRACED_REFLECTION | FEATURE_TRACED_GLASS;

// Macros, not functions: the driver's compiler removes `if (false)` while it parses, but a call only
// after it has inlined and optimised everything that the branch holds, which took 12 to 22 times as
// long (627 ms against 28 for a plain surface).
#define has(feature) ((FEATURES & (feature)) != 0u)
