// The layers of a material at a pixel, after material.glsl's texCoordBy() and vertexNormal. Only what
// LAYERS selects is fetched, and only its maps are declared, by passes/shader_library.cpp.

vec2 layerTexCoordOf(int slot) {
    int row = 2 * (slot - BASE_SLOTS);
    return texCoordBy(layerBlock.texCoordRows[row], layerBlock.texCoordRows[row + 1]);
}

// KHR_materials_specular: of the dielectric's reflectance, at normal incidence and edge-on.
void applySpecularMaps(inout vec4 dielectric, inout float grazing) {
    if (layered(LAYER_SPECULAR_MAP)) {
        float factor = texture(specularMap, layerTexCoordOf(SLOT_SPECULAR)).a;
        dielectric *= factor;
        grazing *= factor;
    }
    if (layered(LAYER_SPECULAR_COLOR_MAP)) {
        dielectric.rgb *= texture(specularColorMap, layerTexCoordOf(SLOT_SPECULAR_COLOR)).rgb;
    }
}

vec3 clearcoatNormalAt() {
    vec3 n = vertexNormal;
    if (!layered(LAYER_CLEARCOAT_NORMAL_MAP)) return turnedToEye(direction(n));
    return bumpedNormal(n, texture(clearcoatNormalMap, layerTexCoordOf(SLOT_CLEARCOAT_NORMAL)), false,
                        layerBlock.clearcoat.z);
}
Turn clearcoatTurnAt(vec3 x, vec3 y, Layers l) {
    if (!layered(LAYER_CLEARCOAT_NORMAL_MAP)) return evenTurn(x, y);
    return turnIn(clearcoatNormalMap, layerTexCoordOf(SLOT_CLEARCOAT_NORMAL), x, y,
                  l.clearcoatNormal, false, layerBlock.clearcoat.z, l.clearcoatRoughness);
}

// normal: of the base, unit, on the side that is seen.
Layers layersAt(vec3 normal) {
    Layers l = noLayers();
    if (layered(LAYER_CLEARCOAT)) {
        l.clearcoat = layerBlock.clearcoat.x;
        l.clearcoatRoughness = layerBlock.clearcoat.y;
        if (layered(LAYER_CLEARCOAT_MAP)) {
            l.clearcoat *= texture(clearcoatMap, layerTexCoordOf(SLOT_CLEARCOAT)).r;
        }
        if (layered(LAYER_CLEARCOAT_ROUGHNESS_MAP)) {
            l.clearcoatRoughness *=
                texture(clearcoatRoughnessMap, layerTexCoordOf(SLOT_CLEARCOAT_ROUGHNESS)).g;
        }
        l.clearcoatNormal = clearcoatNormalAt();
    }
    if (layered(LAYER_SHEEN)) {
        l.sheen = layerBlock.sheen.rgb;
        l.sheenRoughness = layerBlock.sheen.w;
        if (layered(LAYER_SHEEN_COLOR_MAP)) {
            l.sheen *= texture(sheenColorMap, layerTexCoordOf(SLOT_SHEEN_COLOR)).rgb;
        }
        if (layered(LAYER_SHEEN_ROUGHNESS_MAP)) {
            l.sheenRoughness *= texture(sheenRoughnessMap, layerTexCoordOf(SLOT_SHEEN_ROUGHNESS)).a;
        }
    }
    if (layered(LAYER_IRIDESCENCE)) {
        l.film = layerBlock.iridescence.x;
        l.filmIor = layerBlock.iridescence.y;
        l.filmThickness = layerBlock.iridescence.w;
        if (layered(LAYER_IRIDESCENCE_MAP)) {
            l.film *= texture(iridescenceMap, layerTexCoordOf(SLOT_IRIDESCENCE)).r;
        }
        if (layered(LAYER_IRIDESCENCE_THICKNESS_MAP)) {
            float part =
                texture(iridescenceThicknessMap, layerTexCoordOf(SLOT_IRIDESCENCE_THICKNESS)).g;
            l.filmThickness = mix(layerBlock.iridescence.z, layerBlock.iridescence.w, part);
        }
    }
    if (layered(LAYER_ANISOTROPY)) {
        l.anisotropy = layerBlock.anisotropy.x;
        vec2 along = layerBlock.anisotropy.yz;
        if (layered(LAYER_ANISOTROPY_MAP)) {
            vec3 texel = texture(anisotropyMap, layerTexCoordOf(SLOT_ANISOTROPY)).rgb;
            l.anisotropy *= texel.b;
            along = grainOf(along, texel.xy);
        }
        l.grain = grainDirection(normal, vertexTangent.xyz,
                                 cross(vertexNormal, vertexTangent.xyz) * vertexTangent.w, along);
    }
    if (layered(LAYER_DIFFUSE_TRANSMISSION)) {
        l.through = layerBlock.diffuseTransmission.rgb;
        l.throughShare = layerBlock.diffuseTransmission.w;
        if (layered(LAYER_DIFFUSE_TRANSMISSION_MAP)) {
            l.throughShare *=
                texture(diffuseTransmissionMap, layerTexCoordOf(SLOT_DIFFUSE_TRANSMISSION)).a;
        }
        if (layered(LAYER_DIFFUSE_TRANSMISSION_COLOR_MAP)) {
            l.through *= texture(diffuseTransmissionColorMap,
                                 layerTexCoordOf(SLOT_DIFFUSE_TRANSMISSION_COLOR))
                             .rgb;
        }
    }
    return l;
}
