// The uniform blocks, declared once for GLSL and C++: only vec4, ivec4 and mat4 members, so that
// std140 and C++ agree byte for byte.
// "Eye" space has its origin at the eye and the axes of the environment map, so that no pixel has to
// turn a direction. Channel passes, which know no environment, keep the world's axes.

BLOCK_BEGIN(ViewBlock, BINDING_VIEW)
    mat4 clipFromEye;
    vec4 environment;       // last roughness level, intensity, clip depth of the far end; samples
    vec4 forward;           // unit, where the camera looks; w: 1 when it is orthographic
    vec4 skyDirections[3];  // at the picture's centre; its change to the right edge; to the top
    vec4 clipPlane;         // kept: dot(xyz, p) + w >= 0
    vec4 picture;           // width, height, pixels per unit of slope, 1 / diagonal of the scene
    vec4 worldFromEye[3];   // rows; w: the eye in the world, only for the channel of positions
    vec4 backdrop;          // last level; radiance of a background that replaces the map
    // 1 / width and 1 / height of the shadow map, samples of soft shadows; 1: there is such a background
    vec4 shadows;
    vec4 sampling;          // x: edge of the square that a sample represents, pixels; yz: width and
                            // height of the shadow map / those of its part without nearer pictures
BLOCK_END(view)

BLOCK_BEGIN(MaterialBlock, BINDING_MATERIAL)
    vec4 baseColor;
    vec4 surface;           // metallic, roughness, normal scale, occlusion strength
    vec4 emissive;          // rgb: radiance; w: alpha cutoff
    vec4 dielectricF0;      // rgb; w: specular weight
    vec4 glass;             // transmission, ior, thickness (mesh space), attenuation distance
    vec4 attenuation;       // rgb; w: what the dielectric lobe reflects edge-on
    vec4 texCoordRows[14];  // slot s: u = dot(row[2s].xyz, (uv, 1)), v by row[2s + 1]; w: which set
    vec4 sides;             // x: 1 if both are drawn, else 0
BLOCK_END(material)

BLOCK_BEGIN(LayerBlock, BINDING_LAYERS)
    vec4 clearcoat;            // factor, roughness, normal scale, dispersion
    vec4 sheen;                // rgb; w: roughness
    vec4 iridescence;          // factor, ior, least and greatest thickness (nanometres)
    vec4 anisotropy;           // strength, cosine and sine of the rotation
    vec4 diffuseTransmission;  // rgb; w: factor
    vec4 texCoordRows[24];     // as in MaterialBlock, of the slots from SLOT_SPECULAR on
BLOCK_END(layerBlock)

BLOCK_BEGIN(PrefilterBlock, BINDING_PREFILTER)
    vec4 faceAxes[3];  // the face's normal, and its directions of growing s and t
    ivec4 counts;      // samples; axis of a blur
    // toLight about +Z; w: level of the source. Of a blur: cosine and sine of a turn, its weight.
    vec4 samples[PREFILTER_SAMPLES];
BLOCK_END(prefilter)

BLOCK_BEGIN(ReflectionBlock, BINDING_REFLECTION)
    vec4 picture;   // of a flat mirror: texture coordinate = gl_FragCoord.xy * xy + zw
    vec4 levels;    // last level; pixels per unit of slope; edge of a cube's face; samples
    vec4 center;    // of a probe, in eye space
    vec4 proxyMin;  // its box about its centre, the world's axes
    vec4 proxyMax;
    vec4 ownFromMap[3];  // rows: of a stored map, its own axes from eye space
    vec4 normal;    // of a flat mirror, unit, towards the eye
BLOCK_END(reflection)

BLOCK_BEGIN(TraceBlock, BINDING_TRACE)
    vec4 eye;     // from the hierarchy's origin, the world's axes; w: number of nodes
    vec4 limits;  // turns of a ray
    vec4 background;  // radiance that replaces the map for rays that nothing reflected; w: 1
BLOCK_END(tracing)

BLOCK_BEGIN(FilterBlock, BINDING_FILTER)
    // toneMap: exposure factor; 1 if the edge filter follows, else 0.
    // Transparent pictures: 1 as the third number. twirl: radians per pixel, radius. convolve: 1 if
    // it repeats. glowBright: threshold. glowUp: share of the wider one. glow: threshold, strength.
    // lens: the first pixel of the part; above 0 for depth.
    // A further sample of pixels: the colour that it begins with.
    vec4 parameters;
    vec4 kernel[3];  // convolve: rows, the first on top
BLOCK_END(filtering)
