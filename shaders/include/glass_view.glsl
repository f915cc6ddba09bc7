// Glass over a backdrop: the light behind it is read from a copy of the picture drawn so far, at the
// point where the ray that leaves the glass hits the scene. After reflection.glsl and punctualLightOn().

layout(binding = UNIT_BACKDROP) uniform sampler2D backdrop;
// Outward normals of the nearest back faces, and their distances; alpha 0 without a back face.
layout(binding = UNIT_BACK_FACES) uniform sampler2D backFaces;

// Metres along a ray that leaves the glass at `exit` until it is so far from the eye.
float metresBeyond(vec3 exit, vec3 towards, float far) {
    float along = dot(exit, towards);
    float root = sqrt(max(along * along + (far * far - dot(exit, exit)), 0.0f));
    return max(root - along, 0.0f);
}
// Until it is as far as the object that the backdrop shows at `at`.
float beyondGlass(vec3 exit, vec3 towards, vec2 at, float lod) {
    float stored = textureLod(backdrop, at, lod).a;
    return metresBeyond(exit, towards, shareStored(stored) / view.picture.w);
}
// A blurred backdrop so many times as far as things can be shows the sky only.
const float kOnlySky = 4.0f;

vec3 projected(vec3 point) {  // texture coordinates; z: how far in front of the eye
    vec4 clip = view.clipFromEye * vec4(point, 1.0f);
    return vec3(clip.xy / max(clip.w, 1e-30f) * 0.5f + 0.5f, clip.w);
}

// The background along a ray that has left the glass.
vec3 backgroundAlong(vec3 towards, float roughness) {
    return view.shadows.w > 0.0f ? view.backdrop.yzw : environmentAlong(towards, roughness);
}

// The same for a surface whose surroundings hide a part of it.
vec3 surroundingsAlong(Surface s, vec3 towards, float roughness) {
    return reachingSurface(s, towards, backgroundAlong(towards, roughness));
}

// A lobe as the mean of two blurred pictures. A read from a level whose texels are w wide is the mean under
// nearly a Gaussian of deviation w / 2 (the texel, and linear interpolation between texels). Two of these with
// 0.55 and 1.5 times the median slope s have the energy of GGX within s (0.50), 2 s (0.79, GGX 0.80) and in the
// middle (0.30 / s^2, GGX 0.32). lod: see lobeLod(), sqrt(6) s wide.
vec3 blurredBackdrop(vec2 at, float lod) {
    if (lod <= 0.0f) return textureLod(backdrop, at, 0.0f).rgb;
    float last = view.backdrop.x;
    return 0.5f * (textureLod(backdrop, at, clamp(lod - 1.155f, 0.0f, last)).rgb +
                   textureLod(backdrop, at, min(lod + 0.293f, last)).rgb);
}

// Light along a ray that has left the glass. Where the picture ends, a body shows its surroundings.
vec3 behindGlass(Surface s, vec3 exit, vec3 towards, float lobe) {
    float spread = lobe * inversesqrt(1.0f + kSteepFacets * lobe * s.roughness * s.roughness);
    float last = view.backdrop.x;
    float away = length(exit);
    // First guess: the ray hits what is behind its exit; second guess: what is at the first.
    float first = beyondGlass(exit, towards, projected(exit).xy, 0.0f);
    vec3 guess = projected(exit + towards * first);
    vec2 at = guess.z > 0.0f ? guess.xy : projected(exit).xy;
    float second = beyondGlass(exit, towards, at, 0.0f);
    float beyond = second;
    float sky = 0.0f;
    float wide = lobeLod(spread, 0.25f * view.picture.z * lobeReach(away, second));
    if (wide > 0.0f) {
        // What is nearer in a quarter of the lobe is blurred as it is there, and the sky next to it with it.
        // Things are at most as far as the scene reaches; where all that is the sky, the map has it without
        // things near the lobe.
        float around = shareStored(textureLod(backdrop, at, min(wide, last)).a);
        float farthest = away * view.picture.w + 1.0f;
        // Next to a thing the mean with the sky is farther than the thing, which is behind the glass: it is
        // taken as a third of the way, in logarithms, from the glass.
        float things = min(around, farthest);
        float glass = max(away * view.picture.w, 1e-6f);
        if (second * view.picture.w > farthest) things = glass * pow(things / glass, 1.0f / 3.0f);
        beyond = min(second, metresBeyond(exit, towards, things / view.picture.w));
        sky = smoothstep(farthest, kOnlySky * farthest, around);
    }
    vec3 there = projected(exit + towards * beyond);
    vec3 seen = blurredBackdrop(there.xy, lobeLod(spread, view.picture.z * lobeReach(away, beyond)));
    if (sky > 0.0f) seen = mix(seen, backgroundAlong(towards, min(spread, 1.0f)), sky);
    // Beyond the edge of the picture a pane shows the colour at the edge, which is close to the right
    // one; a body refracts rays too far for that and shows the environment. relMSE compared with traced
    // paths, for glass at the edge of five pictures, three of them indoors: the colour at the edge has
    // 1.10 times that of the environment (1.00 to 1.39), a fade over a tenth of the picture 1.01 times.
    bool outside = has(FEATURE_SOLID) && (there.z <= 0.0f || there.x < 0.0f || there.y < 0.0f ||
                                          there.x > 1.0f || there.y > 1.0f);
    return outside ? surroundingsAlong(s, towards, min(spread, 1.0f)) : seen;
}

// Through a body of any shape whose back faces were drawn: iterates from a guess along the straight
// line to the back face near which the refracted ray leaves. Without a back face it is a ball of
// `thickness`. Light that is reflected at the exit is counted as leaving there.
const int kBackFaceSteps = 3;
Crossing throughBody(vec3 position, vec3 incident, vec3 normal, float ior, float thickness) {
    Crossing crossing = throughBall(incident, normal, ior, thickness);
    vec4 back = texelFetch(backFaces, ivec2(gl_FragCoord.xy), 0);
    float path = max(back.a / view.picture.w - length(position), 0.0f);
    for (int i = 0; i < kBackFaceSteps; ++i) {
        vec3 guess = position + crossing.inside * path;
        vec4 there = textureLod(backFaces, projected(guess).xy, 0.0f);
        vec3 met = guess * (there.a / (view.picture.w * max(length(guess), 1e-30f)));
        bool known = there.a > 0.0f && dot(there.xyz, there.xyz) > 0.25f;
        path = known ? max(dot(met - position, crossing.inside), 0.0f) : path;
        back = known ? there : back;
    }
    if (back.a > 0.0f && !crossing.total) {
        crossing.path = path;
        crossing.offset = crossing.inside * path;
        crossing.direction = refractedOut(crossing.inside, direction(back.xyz), ior).direction;
    }
    return crossing;
}

// The greatest curvature within this pixel, 1 / metres.
float curvatureAt(vec3 position) {
    vec3 n = direction(vertexNormal);
    vec2 turn = vec2(length(dFdx(n)), length(dFdy(n)));
    vec2 way = vec2(length(dFdx(position)), length(dFdy(position)));
    return max(turn.x / max(way.x, 1e-30f), turn.y / max(way.y, 1e-30f));
}

struct Glass {
    float transmission;
    float ior;
    float thickness;  // metres
    vec3 tint;
};

Glass glassAt(vec3 baseColor) {
    Glass g;
    g.transmission = material.glass.x;
    if (has(FEATURE_TRANSMISSION_MAP)) {
        g.transmission *= texture(transmissionMap, texCoordOf(SLOT_TRANSMISSION)).r;
    }
    g.thickness = material.glass.z;
    if (has(FEATURE_THICKNESS_MAP)) {
        g.thickness *= texture(thicknessMap, texCoordOf(SLOT_THICKNESS)).g;
    }
    g.thickness *= modelScale;
    g.ior = material.glass.y;
    g.tint = baseColor;
    return g;
}

// The backdrop of a near wall shows the far one. The way to the light crosses it where the way goes from
// before what the backdrop shows to behind it; things in front of the way are not crossed. Each step is
// twice as long as the one before.
const int kStepsToLight = 8;
float lightBeforeFarWall(vec3 position, vec3 source, float metres) {
    vec3 end = metres > 0.0f ? source : position + source / view.picture.w;
    float before = length(position);
    for (int i = 1; i <= kStepsToLight; ++i) {
        vec3 point = mix(position, end, exp2(float(i - kStepsToLight)));
        vec3 at = projected(point);
        if (at.z <= 0.0f || at != clamp(at, vec3(0.0f), vec3(1.0f, 1.0f, at.z))) break;
        float seen = shareStored(textureLod(backdrop, at.xy, 0.0f).a) / view.picture.w;
        float away = length(point);
        if (seen >= before && seen < away) return 0.0f;
        before = away;
    }
    return 1.0f;
}

// Radiance of the lights behind rough glass. spread: see glassSpread(). The near wall of a shell, which turns
// rays from the eye before the far one does, blurs the picture of that but not the directions in which it
// is seen.
const float kBothWalls = 1.4142136f;
vec3 lightsBehind(Surface s, vec3 position, Crossing way, float ior, float spread) {
    if (!has(FEATURE_LIGHTS) || s.roughness < kMinRoughness) return vec3(0.0f);
    Surface back = behindPane(s, isFarWall() ? kBothWalls * spread : spread);
    if (has(FEATURE_SOLID)) back = behindBody(s, way.direction, way.path, ior, spread);
    back.inner = has(FEATURE_BACKDROP) && isNearWall();
    return punctualLightOn(back, position + way.offset);
}

// Radiance towards the eye from the environment and the scene.
struct GlassLight {
    vec3 mirrored;  // radiance along the mirrored ray
    vec3 clear;     // of glass that is all clear
    // Shares in `clear` of the radiance along the mirrored ray and of that through the glass.
    vec3 mirroredShare;
    vec3 throughShare;
};

// The shares under a film, whose reflectance takes the place of the face's own.
GlassShares underFilm(GlassShares shares, Layers l, float c, float fresnel) {
#if HAS_LAYERS
    if (layered(LAYER_IRIDESCENCE)) {
        vec3 face = vec3(min(fresnel, 0.999f));
        vec3 film = filmReflectance(c, l.filmIor, l.filmThickness, vec3(f0FromIor(material.glass.y)));
        vec3 changed = mix(face, film, l.film);
        shares.reflected = clamp(shares.reflected + changed - face, 0.0f, 1.0f);
        shares.transmitted *= (vec3(1.0f) - changed) / (vec3(1.0f) - face);
    }
#endif
    return shares;
}

// roundness: see ballShare(). inside: the eye is in the glass, before one interface.
Crossing crossingOf(vec3 position, vec3 incident, vec3 normal, float ior, float thickness,
                    float roundness, bool inside) {
    if (!has(FEATURE_SOLID)) return throughPane(incident, normal, ior, thickness);
    if (inside) {
        Crossing way;
        way.offset = vec3(0.0f);
        way.direction = refracted(incident, normal, 1.0f / ior).direction;
        return way;
    }
    if (has(FEATURE_BACK_FACES)) return throughBody(position, incident, normal, ior, thickness);
    return crossingBetween(throughPane(incident, normal, ior, thickness),
                           throughBall(incident, normal, ior, thickness), roundness);
}

vec3 seenThrough(Surface s, Crossing way, vec3 position, float spread) {
    return has(FEATURE_BACKDROP) ? behindGlass(s, position + way.offset, way.direction, spread)
                                 : surroundingsAlong(s, way.direction, min(spread, 1.0f));
}

GlassLight glassLight(Surface s, vec3 position, Glass g) {
    vec3 incident = -s.toEye;
    float c = max(dot(s.normal, s.toEye), 0.0f);
    bool inside = has(FEATURE_SOLID) && !gl_FrontFacing;
    float eta = inside ? 1.0f / g.ior : g.ior;
    float fresnel = fresnelOfBody(c, eta, material.dielectricF0.w);
    float spread = glassSpread(s.roughness * s.roughness, c, g.ior);

    GlassShares shares;
    // Compares neighbouring pixels (derivatives), so all of them must execute it.
    float roundness = has(FEATURE_SOLID) && !has(FEATURE_BACK_FACES)
                      ? ballShare(g.thickness, curvatureAt(position))
                      : 1.0f;
    Crossing way = crossingOf(position, incident, s.normal, g.ior, g.thickness, roundness, inside);
    if (inside) {
        shares.reflected = vec3(fresnel);
        shares.transmitted = vec3(1.0f - fresnel);
    } else if (has(FEATURE_SOLID)) {
        vec3 clear = absorption(material.attenuation.rgb, material.glass.w, way.path);
        GlassShares wall = paneShares(fresnel, clear);
        shares = solidShares(fresnel, clear);
        shares.reflected = mix(wall.reflected, shares.reflected, roundness);
        shares.transmitted = mix(wall.transmitted, shares.transmitted, roundness);
    } else {
        shares = paneShares(fresnel, absorption(material.attenuation.rgb, material.glass.w,
                                                way.path));
    }
    if (!inside) shares = underFilm(shares, s.layers, c, fresnel);
    vec3 behind = seenThrough(s, way, position, spread);
#if HAS_LAYERS
    if (layered(LAYER_DISPERSION) && has(FEATURE_SOLID)) {
        vec3 iors = dispersedIors(g.ior, layerBlock.clearcoat.w);
        Crossing red = crossingOf(position, incident, s.normal, iors.r, g.thickness, roundness, inside);
        Crossing blue = crossingOf(position, incident, s.normal, iors.b, g.thickness, roundness, inside);
        behind.r = seenThrough(s, red, position, spread).r;
        behind.b = seenThrough(s, blue, position, spread).b;
    }
#endif
    behind += lightsBehind(s, position, way, g.ior, spread);
    vec3 mirrored = reflectedRadiance(s, position);
    return GlassLight(mirrored, shares.reflected * mirrored + shares.transmitted * g.tint * behind,
                      shares.reflected, vec3(0.0f));
}

// The same along rays: the mirrored one, and the one that enters or leaves the body.
GlassLight tracedGlassLight(Surface s, vec3 position, Glass g) {
    vec3 incident = -s.toEye;
    float c = max(dot(s.normal, s.toEye), 0.0f);
    bool inside = has(FEATURE_SOLID) && !gl_FrontFacing;
    float eta = inside ? 1.0f / g.ior : g.ior;
    float fresnel = fresnelOfBody(c, eta, material.dielectricF0.w);
    Refraction bent = refracted(incident, s.normal, eta);
    Crossing way = throughPane(incident, s.normal, g.ior, g.thickness);
    vec3 clear = absorption(material.attenuation.rgb, material.glass.w,
                            has(FEATURE_SOLID) ? length(position) : way.path);
    GlassShares shares = paneShares(fresnel, clear);
    vec3 aside = asideInPane(incident, s.normal, way, g.thickness);
    vec3 through = incident;
    if (has(FEATURE_SOLID)) {
        shares.reflected = vec3(fresnel);
        shares.transmitted = vec3(1.0f - fresnel);
        aside = vec3(0.0f);
        through = bent.direction;
    }
    if (!inside) shares = underFilm(shares, s.layers, c, fresnel);
    float lobe = glassSpread(s.roughness * s.roughness, c, g.ior);
    GlassRays rays = tracedThrough(s, position, aside, through, lobe);
    if (!has(FEATURE_SOLID)) rays.through += lightsBehind(s, position, way, g.ior, lobe);
    vec3 absorbed = inside ? clear : vec3(1.0f);  // on the way to the eye
    vec3 mirroredShare = absorbed * shares.reflected;
    vec3 throughShare = absorbed * shares.transmitted * (inside ? vec3(1.0f) : g.tint);
    return GlassLight(rays.mirrored,
                      mirroredShare * rays.mirrored + throughShare * rays.through,
                      mirroredShare, throughShare);
}

// Light that leaves a surface of glass towards the eye.
vec3 shadedGlass(MaterialPoint m, Surface s) {
    Glass g = glassAt(m.baseColor.rgb);
    Surface lit = s;  // direct light applies to the fraction that does not transmit
    lit.diffuse *= 1.0f - g.transmission;
    float clear = clearShare(g.transmission, m.metallic);
    m.metallic = metallicBesideGlass(g.transmission, m.metallic);
    Surface opaque = surfaceOf(m, s.toEye, s.nDotV);
    opaque.light = s.light;
    GlassLight light = has(FEATURE_TRACED_GLASS) ? tracedGlassLight(s, positionEye, g)
                                                 : glassLight(s, positionEye, g);
    weighRays(mix(opaque.reflectance, light.mirroredShare, clear), clear * light.throughShare);
    return punctualLightAt(lit) + mix(environmentLight(opaque, light.mirrored), light.clear, clear);
}
