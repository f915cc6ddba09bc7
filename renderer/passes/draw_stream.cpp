// Transforms are computed in double precision relative to the eye and then converted to float, so
// that shaders never receive a world coordinate.
#include "passes/draw_stream.h"

#include "passes/blocks.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

glm::vec4 row(const glm::dmat3& m, int i, double w) {
    return glm::vec4(glm::dvec4(m[0][i], m[1][i], m[2][i], w));
}

// As kMinConeWidth of optics.glsl.
constexpr float kMinSpotConeWidth = 1e-3f;

// As shadowAt() in shadow.glsl reads it. The rows of absent nearer pictures are 0, which contain no
// place.
void appendShadow(std::vector<glm::vec4>& rows, const PlacedLight& light, const View& seen,
                  const glm::dmat3& axesFromWorld) {
    const std::size_t first = rows.size();
    static_assert(NEAR_SHADOWS == kMaxNearShadows);
    rows.resize(first + LIGHT_ROWS - 3, glm::vec4(0.0f));
    rows[first + 6].x = light.radius;
    if (!light.shadow) return;
    const auto& [kind, tile, view, nearer] = *light.shadow;
    const bool six = kind == LightShadow::Kind::six;
    const float pictures = six ? 3.0f : (nearer.empty() ? 1.0f : 2.0f);
    const auto texel = static_cast<float>(texelOf(view, tile));
    rows[first] = {pictures, view.orthographic ? 0.0f : texel, view.orthographic ? texel : 0.0f,
                   static_cast<float>(view.znear)};
    rows[first + 6].y =
        view.orthographic ? static_cast<float>(1.0 / view.clipFromView[2][2]) : 0.0f;
    rows[first + 1] = {tile.x, tile.y, tile.width, 1.0f / static_cast<float>(tile.width)};
    if (six) return;
    glm::dmat4 worldFromEye{glm::transpose(axesFromWorld)};
    worldFromEye[3] = glm::dvec4(seen.eye, 1.0);
    const glm::dmat4 clip = glm::transpose(view.clipFromView * view.viewFromWorld * worldFromEye);
    for (int row = 0; row < 4; ++row) {
        rows[first + 2 + static_cast<std::size_t>(row)] = glm::vec4(clip[row]);
    }
    if (seen.lasting) return;
    std::size_t near = first + NEAR_SHADOW_ROW - 3;
    for (const auto& [part, partView] : nearer) {
        const glm::dmat4 &from = view.clipFromView, &to = partView.clipFromView;
        const glm::dvec2 scale(to[0][0] / from[0][0], to[1][1] / from[1][1]);
        const glm::dvec2 offset(to[3][0] - scale.x * from[3][0], to[3][1] - scale.y * from[3][1]);
        rows[near++] = glm::vec4(0.5 * scale, 0.5 * offset + 0.5);
        rows[near++] = glm::vec4(part.x, part.y, part.width, texelOf(partView, part));
    }
}

// seen: what the light is for.
void appendLight(std::vector<glm::vec4>& rows, const PlacedLight& light, const View& seen,
                 const glm::dmat3& axesFromWorld) {
    const bool placed = light.kind != LightKind::directional;
    const bool spot = light.kind == LightKind::spot;
    const glm::vec3 toLight(axesFromWorld * glm::dvec3(light.toLight));
    const glm::vec3 position(axesFromWorld * (light.position - seen.eye));
    rows.emplace_back(placed ? position : toLight, placed ? 1.0f : 0.0f);
    const bool limited = placed && light.range > 0.0f;
    rows.emplace_back(light.intensity, limited ? 1.0f / (light.range * light.range) : 0.0f);
    // spotAttenuation() as a linear function of the cosine; without a cone it is 1.
    const float width = std::max(light.cosInner - light.cosOuter, kMinSpotConeWidth);
    rows.push_back(spot ? glm::vec4(toLight, -light.cosOuter) / width : glm::vec4(0, 0, 0, 1));
    appendShadow(rows, light, seen, axesFromWorld);
}

}  // namespace

void DrawStream::begin(const Scene& scene, const Pose& pose, const View& view,
                       const glm::dmat3& axesFromWorld, const std::vector<PlacedLight>& lights) {
    scene_ = &scene;
    pose_ = &pose;
    view_ = &view;
    axesFromWorld_ = axesFromWorld;
    lights_ = &lights;
    surfaceLight_ = nullptr;
    instances_.clear();
    lists_.clear();
    recordData_.clear();
    lightData_.assign(HARMONIC_ROWS, glm::vec4(0.0f));
}

void DrawStream::setHarmonics(const std::array<glm::vec3, 9>& harmonics, float intensity) {
    for (std::size_t i = 0; i < 27; ++i) {
        const float number = harmonics[i / 3][static_cast<int>(i % 3)] * intensity;
        lightData_[i / 4][static_cast<int>(i % 4)] = number;
    }
}

const DrawStream::InstanceData& DrawStream::instanceData(std::uint32_t instance) {
    const auto [it, isNew] = instances_.try_emplace(instance);
    InstanceData& data = it->second;
    if (!isNew) return data;
    const glm::dmat4& worldFromModel = pose_->worldFromNode[scene_->instances[instance].node];
    const glm::dmat3 linear = axesFromWorld_ * glm::dmat3(worldFromModel);
    const glm::dvec3 translation = axesFromWorld_ * (glm::dvec3(worldFromModel[3]) - view_->eye);
    const glm::dmat3 normals = normalMatrix(linear);
    for (int i = 0; i < 3; ++i) {
        data.record.eyeFromModel[i] = row(linear, i, translation[i]);
        data.record.normalFromModel[i] = row(normals, i, 0.0);
    }
    data.record.normalFromModel[2].w = static_cast<float>(instance + 1);
    data.mirrored = glm::determinant(linear) < 0.0;
    return data;
}

std::uint32_t DrawStream::firstLight(const std::vector<std::uint8_t>& list) {
    // A hit without lights reads the rows of the first light all the same; see
    // punctualLightAtHit().
    if (list.empty()) return 0;
    const auto [it, isNew] = lists_.try_emplace(
        list, static_cast<std::uint32_t>((lightData_.size() - HARMONIC_ROWS) / LIGHT_ROWS));
    if (isNew) {
        for (const std::uint8_t light : list)
            appendLight(lightData_, (*lights_)[light], *view_, axesFromWorld_);
    }
    return it->second;
}

float DrawStream::firstLightValue(std::uint32_t instance) const {
    const std::int32_t first =
        surfaceLight_ ? surfaceLight_->firstOfInstance[instance] : light::kNoLight;
    return light::isConstant(first) ? static_cast<float>(light::constantValue(first)) + 0.5f
                                    : static_cast<float>(first);
}

std::uint32_t DrawStream::add(const std::vector<Draw>& draws) {
    const auto first = static_cast<std::uint32_t>(recordData_.size());
    for (const Draw& draw : draws) {
        DrawRecord record = instanceData(draw.instance).record;
        record.normalFromModel[0].w = static_cast<float>(firstLight(
            {draw.lights.indices.begin(), draw.lights.indices.begin() + draw.lights.count}));
        const bool hasColors = scene_->meshes[scene_->instances[draw.instance].mesh].hasColors;
        const float faces = draw.faces == DrawnFaces::front  ? 0.25f
                            : draw.faces == DrawnFaces::back ? 0.125f
                                                             : 0.0f;
        record.normalFromModel[1].w =
            static_cast<float>(draw.lights.count) + (hasColors ? 0.0f : 0.5f) + faces;
        if (draw.middle) record.normalFromModel[0].w = *draw.middle;
        if (draw.label) record.normalFromModel[2].w = static_cast<float>(*draw.label);
        if (surfaceLight_) record.normalFromModel[2].w = firstLightValue(draw.instance);
        recordData_.push_back(record);
    }
    return first;
}

void DrawStream::upload() {
    records_.assign(std::as_bytes(std::span(recordData_)));
    if (lightData_.size() == HARMONIC_ROWS) lightData_.resize(HARMONIC_ROWS + LIGHT_ROWS);
    lightRows_.assign(std::as_bytes(std::span(lightData_)));
}

gl::Facing DrawStream::facing(const Draw& draw, bool doubleSided) const {
    return {.cullBack = !doubleSided || draw.faces == DrawnFaces::front,
            .cullFront = draw.faces == DrawnFaces::back,
            .clockwiseIsFront = view_->mirrored != instances_.at(draw.instance).mirrored};
}

}  // namespace clerestory
