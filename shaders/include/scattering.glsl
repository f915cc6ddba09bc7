// Punctual light behind rough glass, which it scatters towards the eye. A part of lighting.glsl in programs that
// shade such glass (SCATTERS_LIGHTS): others neither parse it nor test for it at each light.

// Energy that the lobe gains about its middle because steep facets bend light less than in proportion to
// their slope, per alpha and spread; see also evalBaseLight(). Fitted to facets sampled on both faces at
// normal incidence: within 10 % up to 40 degrees for indices of 1.3 to 1.8 and alpha up to 0.64.
const float kSteepFacets = 2.2f;

// The lobe in which rough glass scatters punctual light from behind it towards the eye, as a surface that
// reflects all light: the highlight of a mirror behind the glass that sends the ray from the eye back along
// its way. Through clearer glass than kMinRoughness a light is not seen, as without any. spread: see
// glassSpread().
Surface scatteringBehind(IN(Surface) s, float spread) {
    Surface back = s;
    back.diffuse = vec3(0.0f);
    back.f0 = vec3(1.0f + kSteepFacets * spread * s.roughness * s.roughness);
    back.f90 = back.f0;
    back.bends = true;
    back.between = 0.0f;
    back.averages = false;  // straight through, whatever the normal is
    back.belowSheen = 1.0f;
    back.belowClearcoat = 1.0f;
    back.layers.anisotropy = 0.0f;
    back.layers.through = vec3(0.0f);
    back.layers.sheen = vec3(0.0f);
    back.layers.clearcoat = 0.0f;
    return back;
}
Surface withAlpha(IN(Surface) s, float alpha) {
    Surface other = s;
    float bounded = min(alpha, 1.0f);
    other.alphaSquared = bounded * bounded;
    other.masking =
        sqrt(other.alphaSquared + (1.0f - other.alphaSquared) * other.nDotV * other.nDotV);
    return other;
}
// Of a pane. A tilted facet turns a ray in proportion to 1 / nDotV in the plane of incidence, as a mirror
// does; `spread` is the mean over both planes.
Surface behindPane(IN(Surface) s, float spread) {
    Surface back = scatteringBehind(s, spread);
    // Across a fold of smoothed normals the side of the eye is theirs, not that of the triangles.
    back.normal = dot(s.normal, s.toEye) < 0.0f ? s.normal : -s.normal;
    back.toEye = reflect(s.toEye, s.normal);
    return withAlpha(back, 0.5f * spread * inversesqrt(s.nDotV));
}
// Of a body that the ray from the eye leaves along `towards` after `path` metres in it.
Surface behindBody(IN(Surface) s, vec3 towards, float path, float ior, float spread) {
    Surface back = scatteringBehind(s, spread);
    back.normal = towards;
    back.toEye = towards;
    back.nDotV = 1.0f;
    back.between = path / max(ior, 1.0f);
    return withAlpha(back, 0.5f * spread);
}

// For a light so many metres behind the second face: rays that the first face turns leave the second one
// next to its middle, and so from another direction to the light.
Surface beforeLight(IN(Surface) s, float metres) {
    Surface wide = s;
    if (s.bends && metres > 0.0f) {
        float turn = 1.0f + s.between / max(metres, 1e-3f * s.between);
        wide.alphaSquared = min(0.5f * (1.0f + turn * turn) * s.alphaSquared, 1.0f);
    }
    return wide;
}

// 1 for a light whose way to the near wall of a shell does not cross the far one, else 0. position: of the
// near wall, in eye space; source, metres: as ArrivingLight.
float lightBeforeFarWall(vec3 position, vec3 source, float metres);
