// What the reference computes.
//
//   effects  The renderer's lighting model with every effect computed exactly. Punctual lights cast
//            no shadows, the environment lights diffuse surfaces unoccluded (times the occlusion
//            texture), emitters illuminate nothing, and there is no diffuse interreflection. Traced
//            through the real scene, to any depth: the specular lobes of flat and curved mirrors
//            and of smooth dielectrics of any shape, and everything that glass reflects or
//            refracts. Specular lobes that the renderer classifies as dull, rough or alpha-tested
//            (scene/classification.h, ReflectorReason) reflect the unoccluded environment, as they
//            do there, so that missing global illumination does not count as an error of a mirror.
//            A switch of FrameRequest::effects that is off is off here as well: its surfaces
//            reflect the environment, are opaque, or do not emit.
//   full     Global illumination: shadows, light from emitters and diffuse interreflection.
//            Occlusion textures are ignored.
//            Punctual lights pass through glass unrefracted and attenuated, without caustics.
#pragma once

namespace clerestory {

enum class ReferenceMode { effects, full };

}  // namespace clerestory
