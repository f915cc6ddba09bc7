#include "accuracy_settings.h"

namespace clerestory::bench {
namespace {

MaterialOverride glossyFloor() {
    MaterialOverride o;
    o.material = "floor";
    o.roughness = 0.08;
    o.metallic = 0.6;
    o.reflection = Reflection::mirror;
    return o;
}

MaterialOverride mirroredBoxes() {
    MaterialOverride o;
    o.material = "box.Material";
    o.roughness = 0.0;
    o.metallic = 1.0;
    o.reflection = Reflection::mirror;
    return o;
}

struct SharedScene {
    const char* name;
    const char* file;
    const char* view;  // "@eye:target", or nothing
    MaterialOverride (*change)() = nullptr;
};
constexpr const char* kCornellView = "@-278,274,780:-278,274,-279";
// Views that show much of what the scene is for. With the built-in ones at least five show each
// effect.
constexpr SharedScene kSharedScenes[] = {
    {"MetalRoughSpheres", "MetalRoughSpheresNoTextures/MetalRoughSpheresNoTextures.glb",
     "@0.0045,0.004,0.0095:0.0027,0.0027,0"},
    {"TransmissionTest", "TransmissionTest/TransmissionTest.glb", ""},
    {"TransmissionRoughnessTest", "TransmissionRoughnessTest/TransmissionRoughnessTest.glb",
     "@0.3,0.15,1.7:0,0,0"},
    {"AttenuationTest", "AttenuationTest/AttenuationTest.glb", "@4,2,29:0,0,0"},
    {"EmissiveStrengthTest", "EmissiveStrengthTest/EmissiveStrengthTest.glb", ""},
    {"MosquitoInAmber", "MosquitoInAmber/MosquitoInAmber.glb", ""},
    {"ToyCar", "ToyCar/ToyCar.gltf", ""},
    {"GlassTable", "GlassTable/glass-table.glb", "@2.6,2.1,2.6:0,0.55,0"},
    {"CornellBox", "CornellBox/CornellBox.glb", kCornellView},
    {"CornellBox, mirrored boxes", "CornellBox/CornellBox.glb", kCornellView, mirroredBoxes},
    {"LightsPunctualLamp", "LightsPunctualLamp/LightsPunctualLamp.gltf", ""},
    {"Sponza, glossy floor", "Sponza/Sponza.gltf", "@8,2.5,-0.3:-8,1.0,-0.3", glossyFloor},
};

}  // namespace

std::vector<Accuracy> presets() {
    return {accuracyOf(Preset::draft), accuracyOf(Preset::standard), accuracyOf(Preset::fine)};
}

std::vector<Accuracy> sweep() {
    std::vector<Accuracy> all = presets();
    const auto add = [&](const auto& change) {
        Accuracy a = accuracyOf(Preset::standard);
        change(a);
        all.push_back(a);
    };
    const auto knob = [&](auto Accuracy::*member, const auto&... values) {
        (add([&](Accuracy& a) { a.*member = values; }), ...);
    };
    knob(&Accuracy::planar, PlanarMethod::environment, PlanarMethod::mirror, PlanarMethod::traced);
    knob(&Accuracy::curved, CurvedMethod::environment, CurvedMethod::probe, CurvedMethod::traced);
    knob(&Accuracy::glass, GlassMethod::environment, GlassMethod::backdrop, GlassMethod::traced);
    const auto traced = [](Accuracy& a) {
        a.planar = PlanarMethod::traced;
        a.curved = CurvedMethod::traced;
        a.glass = GlassMethod::traced;
    };
    add(traced);
    add([&](Accuracy& a) {
        a = accuracyOf(Preset::fine);
        traced(a);
    });
    knob(&Accuracy::planarScale, 0.25, 0.5);
    knob(&Accuracy::planarSamples, 4u, 16u);
    knob(&Accuracy::curvedSamples, 8u, 16u);
    knob(&Accuracy::generations, 1u, 4u);
    knob(&Accuracy::probeSize, 64u, 128u, 512u);
    knob(&Accuracy::probeSamples, 1u, 8u, 128u);
    knob(&Accuracy::parallax, Parallax::none, Parallax::depth);
    knob(&Accuracy::backFaces, true);
    knob(&Accuracy::bounces, 2u, 8u);
    knob(&Accuracy::raySamples, 4u);
    knob(&Accuracy::glassRaySamples, 1u);
    knob(&Accuracy::environmentSize, 64u, 256u);
    knob(&Accuracy::environmentSamples, 16u, 256u);
    knob(&Accuracy::samples, 4u);
    knob(&Accuracy::edgeFilter, false);
    return all;
}

std::vector<AccuracyScene> builtinAccuracyScenes() {
    return {{"chapel", "chapel", {}},
            {"teapots", "teapots", {}},
            {"six-walls", "six-walls", {}},
            {"orbiting-cubes", "orbiting-cubes", {}}};
}

std::vector<AccuracyScene> allAccuracyScenes(const std::filesystem::path& shared) {
    std::vector<AccuracyScene> scenes = builtinAccuracyScenes();
    scenes.push_back({"meadow", "meadow", {}});
    scenes.push_back({"room", "room", {}});  // closed on all sides
    for (const SharedScene& s : kSharedScenes) {
        const std::filesystem::path file = shared / s.file;
        if (!std::filesystem::exists(file)) continue;
        AccuracyScene scene{s.name, file.string() + s.view, {}};
        if (s.change) scene.overrides.push_back(s.change());
        scenes.push_back(std::move(scene));
    }
    return scenes;
}

}  // namespace clerestory::bench
