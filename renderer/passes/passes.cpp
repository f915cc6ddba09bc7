// Shared by several pass types: the uniform block of a view, and the loop over draws.
#include "passes/passes.h"

#include "gl/context.h"
#include "passes/blocks.h"
#include "passes/draw_parts.h"
#include "plan/graph/features.h"
#include "plan/graph/view_bits.h"
#include "scene/environment.h"

#include <algorithm>
#include <cstring>
#include <optional>

namespace clerestory {
namespace {

// Large enough to amortise binning into tiles, small enough that rasterisation starts early:
// Sponza's court at 1280x720 takes 101 ms in batches of this size, 113 ms as one batch.
constexpr std::uint32_t kTrianglesPerSubmission = 32'000;

gl::Texture brdfTexture() {
    gl::Texture texture({.format = gl::TextureFormat::rg16f,
                         .width = kEnvironmentBrdfSize,
                         .height = kEnvironmentBrdfSize});
    const std::vector<glm::vec2>& table = environmentBrdfTable();
    texture.upload(0, 0, std::as_bytes(std::span(table)));
    return texture;
}

gl::Texture blackCube() {
    gl::Texture texture({.kind = gl::TextureKind::cube, .format = gl::TextureFormat::rgba16f});
    const glm::vec4 black(0.0f);
    for (std::uint32_t face = 0; face < 6; ++face) {
        texture.upload(0, face, std::as_bytes(std::span(&black, 1)));
    }
    return texture;
}

// Directions in eye space from the picture's centre and towards its right and top.
// x and y of clip space are w times the picture's coordinates, which gives three equations for a
// direction with w = 1. An orthographic view has one direction for the whole picture.
void setSkyDirections(const View& view, const glm::dmat3& eyeFromView, glm::vec4* directions) {
    directions[0] = directions[1] = directions[2] = glm::vec4(0.0f);
    if (view.orthographic) {
        directions[0] = glm::vec4(glm::vec3(eyeFromView * glm::dvec3(0.0, 0.0, -1.0)), 0.0f);
        return;
    }
    const glm::dmat4& clip = view.clipFromView;
    glm::dmat3 pictureFromView;  // rows x, y, w
    for (int column = 0; column < 3; ++column) {
        pictureFromView[column] = {clip[column][0], clip[column][1], clip[column][3]};
    }
    const glm::dmat3 eyeFromPicture = eyeFromView * glm::inverse(pictureFromView);
    directions[0] = glm::vec4(glm::vec3(eyeFromPicture[2]), 0.0f);
    directions[1] = glm::vec4(glm::vec3(eyeFromPicture[0]), 0.0f);
    directions[2] = glm::vec4(glm::vec3(eyeFromPicture[1]), 0.0f);
}

// The view whose pixels show in their middle what the sample shows.
View displaced(const View& view, const SampledPixels& sampled, const TargetSpec& target) {
    View moved = view;
    const glm::dvec2 shift = -2.0 * sampled.place / glm::dvec2(target.width, target.height);
    for (int column = 0; column < 4; ++column) {
        glm::dvec4& c = moved.clipFromView[column];
        c.x += shift.x * c.w;
        c.y += shift.y * c.w;
    }
    return moved;
}

}  // namespace

PassResources::PassResources()
    : noVertices({}, nullptr), environmentBrdf(brdfTexture()), darkness(blackCube()) {}

void bindView(PassResources& resources, const PassInput& input, const PassView& seen,
              const glm::dmat3& axesFromWorld) {
    const View view =
        input.sampled ? displaced(seen.view, *input.sampled, input.target().spec()) : seen.view;
    const glm::dmat3 eyeFromView =
        axesFromWorld * glm::transpose(glm::dmat3(view.viewFromWorld));  // orthogonal
    const bool clipControl = gl::Context::current().capabilities().clipControl;
    const bool lit = seen.environment != kNoTarget;

    blocks::ViewBlock block{};
    block.clipFromEye = glm::mat4(gl::deviceClip(view.clipFromView, clipControl) *
                                  glm::dmat4(glm::transpose(eyeFromView)));
    const float lastLevel =
        lit ? static_cast<float>(input.read(seen.environment).spec().levels - 1) : 0.0f;
    block.environment = {lastLevel, input.plan.environmentIntensity, clipControl ? 0.0f : -1.0f,
                         static_cast<float>(input.plan.curvedSamples)};
    block.forward = glm::vec4(glm::vec3(eyeFromView * glm::dvec3(0.0, 0.0, -1.0)),
                              view.orthographic ? 1.0f : 0.0f);
    setSkyDirections(view, eyeFromView, block.skyDirections);
    if (view.clipPlane) {
        block.clipPlane = glm::vec4(glm::vec3(axesFromWorld * glm::dvec3(*view.clipPlane)),
                                    static_cast<float>(view.clipPlane->w));
    }
    const TargetSpec& target = input.target().spec();
    block.picture = {target.width, target.height, 0.5 * target.height * view.clipFromView[1][1],
                     input.plan.inverseDiagonal};
    if (seen.backdrop != kNoTarget) {
        block.backdrop.x = static_cast<float>(input.read(seen.backdrop).spec().levels - 1);
    }
    if (input.plan.shadowMap != kNoTarget) {
        const TargetSpec& map = input.read(input.plan.shadowMap).spec();
        block.shadows = {1.0f / static_cast<float>(map.width),
                         1.0f / static_cast<float>(map.height),
                         static_cast<float>(input.plan.shadowSamples), 0.0f};
        const TargetRect& whole = input.plan.wholeShadows;
        block.sampling.y = static_cast<float>(map.width) / static_cast<float>(whole.width);
        block.sampling.z = static_cast<float>(map.height) / static_cast<float>(whole.height);
    }
    block.sampling.x = input.sampled ? input.sampled->edge : 1.0f;
    if (const auto& radiance = seen.background.radiance) {
        block.backdrop = {block.backdrop.x, radiance->x, radiance->y, radiance->z};
        block.shadows.w = 1.0f;
    }
    for (int row = 0; row < 3; ++row) {  // the transpose of a rotation
        block.worldFromEye[row] =
            glm::vec4(glm::vec3(axesFromWorld[row]), static_cast<float>(view.eye[row]));
    }
    resources.viewBlock.assign(blocks::bytesOf(block));
    resources.viewBlock.bindUniform(BINDING_VIEW);
}

std::size_t reflectionStride() {
    const std::size_t alignment = gl::Context::current().capabilities().uniformAlignment;
    return (sizeof(blocks::ReflectionBlock) + alignment - 1) / alignment * alignment;
}

void uploadReflections(PassResources& resources, const PassInput& input, const PassView& view,
                       const glm::dmat3& axesFromWorld) {
    const std::span<const ReflectedPicture> reflections = view.reflections;
    std::vector<std::byte> bytes(reflectionStride() * std::max<std::size_t>(1, reflections.size()));
    for (std::size_t i = 0; i < reflections.size(); ++i) {
        const ReflectedPicture& r = reflections[i];
        const TargetSpec& target = input.targets[r.target]->spec();
        const glm::dvec2 perPixel = r.scale / glm::dvec2(target.width, target.height);
        blocks::ReflectionBlock block{};
        block.picture = glm::vec4(glm::vec2(perPixel), glm::vec2(-r.origin * perPixel));
        block.levels = {target.levels - 1, r.pixelsPerSlope, target.width, r.samples};
        block.center = glm::vec4(glm::vec3(axesFromWorld * (r.center - view.view.eye)), 0.0f);
        block.proxyMin = glm::vec4(glm::vec3(r.proxyMin), 0.0f);
        block.proxyMax = glm::vec4(glm::vec3(r.proxyMax), 0.0f);
        block.normal = glm::vec4(glm::vec3(axesFromWorld * r.normal), 0.0f);
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) {
                block.ownFromMap[row][column] = static_cast<float>(r.ownFromMap[column][row]);
            }
        }
        std::memcpy(bytes.data() + i * reflectionStride(), &block, sizeof block);
    }
    resources.reflectionBlock.assign(bytes);
    // The range that an earlier pass bound may be beyond the end of the new content.
    resources.reflectionBlock.bindUniform(BINDING_REFLECTION, 0, sizeof(blocks::ReflectionBlock));
}

namespace {

void bindReflection(PassResources& resources, const PassInput& input, const PassView& view,
                    const Draw& draw) {
    const bool cube = (draw.features & (FEATURE_PROBE | FEATURE_MAP)) != 0;
    const ReflectedPicture& reflection = view.reflections[draw.reflection];
    const unsigned unit = cube ? UNIT_ENVIRONMENT : UNIT_MIRROR;
    input.targets[reflection.target]->texture().bind(unit);
    resources.samplers.sampler({.levels = gl::LevelFilter::linear}).bind(unit);
    resources.reflectionBlock.bindUniform(BINDING_REFLECTION, draw.reflection * reflectionStride(),
                                          sizeof(blocks::ReflectionBlock));
}

gl::Topology topologyOf(Primitive primitive) {
    switch (primitive) {
        case Primitive::points:
            return gl::Topology::points;
        case Primitive::lines:
            return gl::Topology::lines;
        case Primitive::triangles:
            break;
    }
    return gl::Topology::triangles;
}

}  // namespace

void settleSamplers(PassResources& resources) {
    resources.environmentBrdf.bind(UNIT_SOURCE);
    resources.samplers.sampler({}).bind(UNIT_SOURCE);
    resources.shaders.program({"settle_samplers.vert", "settle_samplers.frag"}).use();
    gl::drawTriangle();
}

ProgramKey keyOf(const FramePlan& plan, const DrawProgram& program, Features features,
                 std::uint32_t bits) {
    ProgramKey key{.vertex = program.vertex,
                   .fragment = program.fragment,
                   .features = features & program.relevant,
                   .variant = program.variant,
                   .view = bits,
                   .recordsRays = program.recordsRays};
    if (tracesRays(key)) {  // the plan knows the features of all hits; see hit.glsl
        key.variant = static_cast<int>(plan.rays->hitFeatures);
        key.hitLayers = static_cast<std::uint32_t>(plan.rays->hitFeatures >> 32);
    }
    return key;
}

bool isInterrupted(PassResources& resources, const PassInput& input) {
    resources.interrupted = resources.interrupted || (input.abandoned && input.abandoned());
    return resources.interrupted;
}

void drawAll(PassResources& resources, const PassInput& input, const PassView& view,
             std::span<const Draw> draws, std::uint32_t firstRecord, const DrawProgram& program) {
    const std::uint32_t bits = program.materials
                                   ? viewBits(input.plan, view.view, view.background.coverage,
                                              input.surfaceLight != nullptr)
                                   : 0;
    const TextureFilter filter{.anisotropy = input.plan.anisotropy,
                               .colorLevelsBelow = COLOR_LEVELS_BELOW + (input.sampled ? 1 : 0)};
    if (resources.interrupted) return;
    input.scene->vertexArray().bind();
    std::optional<DrawParts> parts;
    if (input.abandoned && gl::Context::current().capabilities().software) {
        parts.emplace(input.scene->scene(), input.scene->clusterAreas(), input.pose, view.view,
                      gl::drawnPixels());
    }
    std::optional<gl::Fence> before;
    double unfinished = 0.0;  // fragments
    std::optional<Features> boundFeatures;
    Index boundMaterial = kNone;
    std::uint32_t boundReflection = kNoReflection;
    std::optional<gl::Facing> facing;
    std::uint32_t unsubmitted = 0;  // triangles, lines and points
    for (std::size_t i = 0; i < draws.size(); ++i) {
        const Draw& draw = draws[i];
        const Features features = draw.features & program.relevant;
        if (boundFeatures != features) {
            const ProgramKey key = keyOf(input.plan, program, features, bits);
            if (gl::Context::current().capabilities().compilesInThreads &&
                !resources.shaders.holds(key)) {
                beginPrograms(resources, input);
            }
            // Its tables have slots where the programs before it in this pass have textures.
            if (tracesRays(key)) settleSamplers(resources);
            resources.shaders.program(key).use();
            boundMaterial = kNone;  // other features read other textures
        }
        boundFeatures = features;
        if (program.materials && boundMaterial != draw.material) {
            input.scene->bindMaterial(draw.material,
                                      {input.plan.materials, resources.frameMaterials}, features,
                                      filter, resources.samplers);
            boundMaterial = draw.material;
        }
        if (program.materials && draw.reflection != boundReflection) {
            if (draw.reflection != kNoReflection)
                bindReflection(resources, input, view, draw);
            else
                bindEnvironment(resources, input, view.environment);  // where a probe's cube may be
            boundReflection = draw.reflection;
        }
        gl::Facing wanted =
            resources.draws.facing(draw, (draw.features & FEATURE_DOUBLE_SIDED) != 0);
        if (program.backFaces) wanted.clockwiseIsFront = !wanted.clockwiseIsFront;
        if (facing != wanted) gl::apply(wanted);
        facing = wanted;
        const bool surface = draw.primitive == Primitive::triangles;
        if (!surface) gl::setWidth(draw.pointSize);
        const DrawParts::Part whole[] = {{draw.firstIndex, draw.indexCount, 0.0}};
        for (const DrawParts::Part& part : parts ? parts->of(draw) : std::span(whole)) {
            unfinished += part.fragments;
            if (unfinished > DrawParts::kMaxFragments) {
                // One part is binned while the one before it is filled.
                if (before) before->wait();
                before.emplace();
                unfinished = part.fragments;
                if (isInterrupted(resources, input)) return;
            }
            gl::drawIndexed(topologyOf(draw.primitive), part.firstIndex, part.indexCount,
                            firstRecord + static_cast<std::uint32_t>(i));
        }
        ++resources.counters.drawCalls;
        const std::uint32_t primitives = draw.indexCount / indicesPer(draw.primitive);
        if (surface) resources.counters.triangles += primitives;
        unsubmitted += primitives;
        if (unsubmitted >= kTrianglesPerSubmission) {
            gl::submitDraws();
            unsubmitted = 0;
        }
    }
}

void bindEnvironment(PassResources& resources, const PassInput& input, TargetId environment) {
    const gl::Texture& map =
        environment == kNoTarget ? resources.darkness : input.read(environment).texture();
    map.bind(UNIT_ENVIRONMENT);
    resources.samplers.sampler({.levels = gl::LevelFilter::linear}).bind(UNIT_ENVIRONMENT);
}

}  // namespace clerestory
