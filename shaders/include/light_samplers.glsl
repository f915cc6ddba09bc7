// What surfaces read light from: the environment, a mirrored view, and the table of lights.
//
// Included before the samplers of materials. Mesa leaves the slot of a buffer texture with the sampler
// state that an earlier program had there, and llvmpipe compiles a variant for each state it finds. The
// slots of a program are numbered in the order of these lines. Every lit surface reads the first, and
// the second in a view with shadows; so the table has the same slot in all programs of a view, and the
// other programs of a pass have no sampler there. In another order the chapel's programs were compiled
// up to four times each.
layout(binding = UNIT_ENVIRONMENT_BRDF) uniform sampler2D environmentBrdf;
layout(binding = UNIT_SHADOWS) uniform sampler2DShadow shadowMap;
// The harmonics of the environment, then the lights; draw_stream.h has the rows.
layout(binding = UNIT_LIGHTS) uniform samplerBuffer lightTable;
layout(binding = UNIT_ENVIRONMENT) uniform samplerCube environmentMap;
layout(binding = UNIT_MIRROR) uniform sampler2D mirrorPicture;
layout(binding = UNIT_SHADOW_DEPTHS) uniform sampler2D shadowDepths;  // of shadowMap
layout(binding = UNIT_SHADOW_TINTS) uniform sampler2D shadowTints;  // of what lets light through
