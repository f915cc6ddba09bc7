#include "server/api/openapi.h"

#include <nlohmann/json.hpp>

namespace clerestory {
namespace {

using nlohmann::ordered_json;

const ordered_json kText = {{"type", "string"}}, kNumber = {{"type", "number"}},
                   kCount = {{"type", "integer"}, {"minimum", 0}}, kFlag = {{"type", "boolean"}};

ordered_json described(ordered_json schema, const char* words) {
    schema["description"] = words;
    return schema;
}

// `always`: required fields. `sometimes`: optional fields.
ordered_json object(ordered_json always, ordered_json sometimes = ordered_json::object()) {
    ordered_json required = ordered_json::array();
    for (const auto& [name, schema] : always.items()) required.push_back(name);
    always.update(sometimes);
    ordered_json schema = {{"type", "object"}, {"properties", std::move(always)}};
    if (!required.empty()) schema["required"] = std::move(required);
    return schema;
}

ordered_json listOf(ordered_json items) {
    return {{"type", "array"}, {"items", std::move(items)}};
}

ordered_json numbers(int count) {
    return {{"type", "array"}, {"items", kNumber}, {"minItems", count}, {"maxItems", count}};
}

ordered_json oneOf(std::initializer_list<const char*> words) {
    return {{"type", "string"}, {"enum", words}};
}

ordered_json problemSchema() {
    const ordered_json fieldError =
        object({{"pointer", described(kText, "JSON Pointer (RFC 6901) of the field")},
                {"detail", described(kText, "what is wrong with it")},
                {"allowed", described(kText, "the allowed values")}});
    return object(
        {{"type", described(kText, "urn:clerestory:problem: followed by the code")},
         {"code", described(kText, "stable identifier, such as queueFull")},
         {"title", described(kText, "the same for every problem of this code")},
         {"status", described(kCount, "the HTTP status")}},
        {{"detail", described(kText, "what went wrong")},
         {"requestId", described(kText, "as in the X-Request-Id header")},
         {"reason", described(kText, "why a scene or an environment map could not be loaded")},
         {"errors", listOf(fieldError)}});
}

// JSON has no infinity: a measure that is not finite is null.
const ordered_json kMeasure = {{"type", {"number", "null"}}};
const ordered_json kAccuracy = {{"$ref", "#/components/schemas/Accuracy"}};

ordered_json linearErrors(ordered_json more) {
    ordered_json always = {
        {"pixels", kCount},
        {"relMse", kMeasure},
        {"relMseTrimmed", described(kMeasure, "relMse without the 0.1 % of pixels that are worst")},
        {"rmse", kMeasure},
        {"bias", kMeasure},
        {"p95", kMeasure},
        {"meanReference", kMeasure}};
    always.update(more);
    return object(std::move(always), {{"nonFinite", kCount}});
}

ordered_json comparisonSchema() {
    const ordered_json frame = linearErrors(
        {{"psnr", kMeasure},
         {"ssim", kMeasure},
         {"flip", kMeasure},
         {"decibels", kMeasure},
         {"modelDecibels", described(kMeasure, "decibels over the pixels that show the scene")}});
    const ordered_json effect =
        linearErrors({{"relMseOff", kMeasure}, {"relMseNoise", kMeasure}, {"closedGap", kMeasure}});
    const ordered_json setting = object(
        {{"name", kText},
         {"accuracy", kAccuracy},
         {"milliseconds", object({{"cold", kNumber},
                                  {"median", kNumber},
                                  {"p95", kNumber},
                                  {"predictedForEffects", kNumber}})},
         {"counts",
          object(
              {{"passes", kCount}, {"views", kCount}, {"draws", kCount}, {"triangles", kCount}})},
         {"error", object({{"frame", frame}}, {{"emission", effect},
                                               {"refraction", effect},
                                               {"planarReflection", effect},
                                               {"environmentReflection", effect},
                                               {"materialLayers", effect},
                                               {"shadows", effect},
                                               {"indirectLight", effect}})},
         {"closedGap", kMeasure},
         {"jpeg", object({{"psnr", kMeasure}})}},
        {{"errorPicture", described(kText, "path of the picture")}});
    const ordered_json reference = object({{"mode", oneOf({"effects", "full"})},
                                           {"samples", described(kCount, "paths per pixel")},
                                           {"seed", kCount},
                                           {"milliseconds", kNumber},
                                           {"noise", object({{"relMse", kMeasure}})},
                                           {"nonFinite", kCount}},
                                          {{"picture", described(kText, "path of the picture")}});
    return object({{"reference", reference},
                   {"effectsOff", object({{"relMse", kMeasure}})},
                   {"settings", described(listOf(setting), "in the order of the request")}});
}

ordered_json curveSchema() {
    const ordered_json point = object({{"name", kText},
                                       {"accuracy", kAccuracy},
                                       {"milliseconds", kNumber},
                                       {"relMse", kMeasure}});
    return object({{"noise", object({{"relMse", kMeasure}})}, {"points", listOf(point)}});
}

ordered_json jobSchema() {
    return object({{"id", kText},
                   {"state", oneOf({"queued", "running", "done", "failed", "cancelled"})},
                   {"progress", {{"type", "number"}, {"minimum", 0}, {"maximum", 1}}}},
                  {{"failure", described(kText, "why the job failed")},
                   {"result", described({{"anyOf",
                                          {{{"$ref", "#/components/schemas/Comparison"}},
                                           {{"$ref", "#/components/schemas/AccuracyCurve"}}}}},
                                        "of a comparison, or of the measurement for an accuracy "
                                        "budget")}});
}

ordered_json viewSchema() {
    return object(
        {{"viewFromWorld", described(numbers(16), "column-major")},
         {"clipFromView",
          described(numbers(16), "column-major; depth is 1 at znear and 0 at zfar or infinity")},
         {"eye", described(numbers(3), "position in the world")},
         {"znear", kNumber},
         {"orthographic", kFlag},
         {"mirrored", described(kFlag, "front faces are clockwise")}});
}

// The kinds are those of Subject::Kind.
ordered_json subjectSchema() {
    const ordered_json subject = object(
        {{"kind", oneOf({"environment", "map", "mirror", "probe", "glass", "filter", "lights"})},
         {"name", described(kText, "of the object or map, or the type of the filter")}},
        {{"index", described(kCount, "of a filter: its position in the request")}});
    return described({{"oneOf", {subject, {{"type", "null"}}}}},
                     "object, map or filter that it belongs to; null: the view as a whole");
}

// Of the light between surfaces.
ordered_json lightSchema() {
    return object({{"revision", described(kCount, "as in Clerestory-Light; 0: none yet")},
                   {"share", described(kNumber, "of the computation that is complete, 0 to 1")}},
                  {{"failed", described(kFlag, "true if no more of it will be computed")}});
}

ordered_json planSchema() {
    const ordered_json pass = object(
        {{"kind", described(kText, "type of the pass")},
         {"name", kText},
         {"subject", subjectSchema()},
         {"effect", described(kText, "the effect that requires it")},
         {"generation", described(kCount, "depth of reflections")},
         {"views", kCount},
         {"draws", kCount},
         {"triangles", kCount},
         {"reads", described(listOf(kText), "targets of earlier passes")},
         {"reason", described(kText, "why it runs")},
         {"viewMatrices", listOf(viewSchema())}},
        {{"target", kText},
         {"width", kCount},
         {"height", kCount},
         {"format", oneOf({"rgba16f", "rgba32f", "srgba8", "rgba32ui", "depth32f"})},
         {"samples", described(kCount, "of supersampling: samples of a pixel with contrast")},
         {"milliseconds", described(kNumber, "measured; only of frames that were drawn")},
         {"paths", described(kCount, "rays followed; only of drawn passes of kind rays")}});
    const ordered_json skipped = object(
        {{"name", kText}, {"subject", subjectSchema()}, {"effect", kText}, {"reason", kText}});
    const ordered_json candidate =
        object({{"method", described(kText, "technique")},
                {"milliseconds", described(kNumber, "predicted time")},
                {"error", described(kNumber, "predicted relative RMSE on its pixels")}});
    const ordered_json decision =
        object({{"name", kText},
                {"subject", subjectSchema()},
                {"effect", kText},
                {"taken", described(kText, "the technique that was chosen")},
                {"reason", kText},
                {"candidates", listOf(candidate)}});
    const ordered_json intrinsics = object({{"fx", kNumber},
                                            {"fy", kNumber},
                                            {"cx", kNumber},
                                            {"cy", kNumber},
                                            {"pixelCenter", oneOf({"half", "integer"})}});
    const ordered_json camera =
        object({{"cameraToWorld", described(numbers(16), "column-major")},
                {"convention", oneOf({"opengl", "opencv"})},
                {"width", kCount},
                {"height", kCount},
                {"znear", kNumber},
                {"lens", {{"$ref", "#/components/schemas/Lens"}}}},
               {{"clipFromView",
                 described(numbers(16), "column-major; of lenses that a matrix describes")},
                {"intrinsics", described(intrinsics, "of perspective and fisheye lenses")}});
    const ordered_json map = object({{"target", kText}, {"subject", subjectSchema()}});
    const ordered_json health =
        object({{"nonFinite", described(kCount, "values, over all targets")},
                {"negative", described(kCount, "values, over all targets")},
                {"targets", listOf(object({{"target", kText},
                                           {"texels", kCount},
                                           {"nonFinite", kCount},
                                           {"negative", kCount}}))}});
    const ordered_json totals =
        object({{"passes", kCount},
                {"views", kCount},
                {"draws", kCount},
                {"triangles", kCount},
                {"samples", described(kCount, "pixels times samples over all passes")}});
    return object(
        {{"passes", listOf(pass)},
         {"skipped", listOf(skipped)},
         {"decisions", listOf(decision)},
         {"totals", totals}},
        {{"camera", camera},
         {"light", lightSchema()},
         {"composition", described(listOf(kText), "what the request changes in the scene")},
         {"health", described(health, "with explain=health: of every target that was drawn")},
         {"maps",
          described(listOf(map), "with explain=maps: of each map, in the order of the parts")}});
}

// An emitter, a piece of glass or a mirror.
ordered_json surface(ordered_json more) {
    ordered_json always = {{"objectId", described(kCount, "value in the channel objectId")},
                           {"node", kText},
                           {"mesh", kText},
                           {"material", kText},
                           {"area", described(kNumber, "square metres")}};
    always.update(more);
    always["reason"] = kText;
    return object(std::move(always));
}

ordered_json sceneFields() {
    const ordered_json bounds = {
        {"oneOf", {object({{"min", numbers(3)}, {"max", numbers(3)}}), {{"type", "null"}}}}};
    return {{"stage", described(kText, "stage of loading")},
            {"progress", {{"type", "number"}, {"minimum", 0}, {"maximum", 1}}},
            {"uploaded", described(kFlag, "a client uploaded it")},
            {"failure", described(kText, "why it could not be loaded")},
            {"reason", described(kText, "code of the failure")},
            {"triangles", kCount},
            {"lines", kCount},
            {"points", kCount},
            {"bounds", bounds},
            {"effects", described(listOf(kText), "effects that the scene needs")}};
}

ordered_json summarySchema(ordered_json more = ordered_json::object()) {
    ordered_json sometimes = sceneFields();
    sometimes.update(more);
    return object({{"id", kText},
                   {"title", kText},
                   {"default", kFlag},
                   {"state", oneOf({"waiting", "loading", "ready", "failed"})}},
                  std::move(sometimes));
}

ordered_json sceneSchema() {
    const ordered_json mirror = {
        {"roughness", kNumber},
        {"reflectance", described(kNumber, "fraction of light reflected along the normal")}};
    ordered_json flat = surface(mirror);
    flat["properties"]["normal"] = numbers(3);
    const ordered_json animation =
        object({{"name", kText}, {"duration", described(kNumber, "seconds")}, {"default", kFlag}});
    const ordered_json camera =
        object({{"name", kText},
                {"position", numbers(3)},
                {"direction", numbers(3)},
                {"orthographic", kFlag}},
               {{"yfov", kNumber},
                {"yHalfHeight", described(kNumber, "of an orthographic camera")},
                {"znear", kNumber},
                {"zfar", kNumber}});
    const ordered_json light = object({{"name", kText},
                                       {"kind", oneOf({"point", "spot", "directional"})},
                                       {"intensity", described(numbers(3), "linear RGB")}},
                                      {{"position", numbers(3)},
                                       {"direction", numbers(3)},
                                       {"range", kNumber},
                                       {"innerConeAngle", kNumber},
                                       {"outerConeAngle", kNumber},
                                       {"radius", described(kNumber, "of the emitting sphere")}});
    const ordered_json probe =
        object({{"name", kText}, {"position", numbers(3)}, {"size", kNumber}},
               {{"node", kText},
                {"resolution", kCount},
                {"zfar", kNumber},
                {"blur", object({{"size", kCount}, {"stdev", kNumber}})}});
    const ordered_json counts = object({{"meshes", kCount},
                                        {"materials", kCount},
                                        {"textures", kCount},
                                        {"images", kCount},
                                        {"instances", kCount},
                                        {"clusters", kCount},
                                        {"vertices", kCount},
                                        {"emitters", kCount},
                                        {"glass", kCount},
                                        {"flatMirrors", kCount},
                                        {"curvedMirrors", kCount}});
    const ordered_json memory = described(
        object({{"meshes", kCount}, {"textures", kCount}, {"maps", kCount}, {"total", kCount}}),
        "bytes");
    const ordered_json warning =
        object({{"code", described(kText, "stable identifier of the warning")},
                {"subject", described(kText, "what it is about, such as a material")},
                {"message", kText},
                {"count", kCount}});
    const ordered_json glass =
        surface({{"kind", oneOf({"pane", "solid"})}, {"transmission", kNumber}, {"ior", kNumber}});
    return summarySchema(
        {{"defaultView",
          object({{"position", numbers(3)}, {"target", numbers(3)}, {"yfov", kNumber}})},
         {"environment", described(kText, "name of its environment map")},
         {"environmentRotation",
          described(numbers(4), "rotation from map to world, quaternion x y z w")},
         {"counts", counts},
         {"memory", memory},
         {"animations", listOf(animation)},
         {"scenes", described(listOf(object({{"id", kText}, {"name", kText}})),
                              "all scenes of the file, if it has several")},
         {"materials", described(listOf(kText),
                                 "names of materials, in the order of the channel "
                                 "materialId, which counts from 1")},
         {"variants", described(listOf(kText), "names of material variants")},
         {"cameras", listOf(camera)},
         {"lights", listOf(light)},
         {"emitters",
          listOf(
              surface({{"radiance", described(numbers(3), "linear RGB, with emissiveStrength")}}))},
         {"glass", listOf(glass)},
         {"flatMirrors", listOf(flat)},
         {"curvedMirrors", listOf(surface(mirror))},
         {"probes", listOf(probe)},
         {"warnings", listOf(warning)},
         {"shaders", object({{"compiled", kCount}, {"total", kCount}, {"finished", kFlag}})},
         {"light", lightSchema()}});
}

ordered_json instancesSchema() {
    ordered_json box = object({{"x", described(kCount, "from the left edge, pixels")},
                               {"y", described(kCount, "from the top edge")},
                               {"width", kCount},
                               {"height", kCount}});
    box["type"] = {"object", "null"};
    const ordered_json instance = object(
        {{"objectId", described(kCount, "value in the channel objectId")},
         {"node", described(kText, "name of its node")},
         {"materialId", described(kCount, "value in the channel materialId")},
         {"classId", described(kCount, "value in the channel classId; 0: no class")},
         {"worldFromModel", described(numbers(16), "transform of its mesh, column-major, metres")},
         {"pixels", described(kCount, "number of pixels that show it")},
         {"amodalPixels", described(kCount, "the same if it were alone in the scene")},
         {"visibleShare", described(kNumber, "pixels / amodalPixels")},
         {"box", described(box, "bounds of its pixels; null: it is hidden")},
         {"amodalBox", described(box, "bounds of amodalPixels, within the frame")}},
        {{"class", described(kText, "name of the class, if it has one")}});
    return object({{"width", described(kCount, "of the frame, pixels")},
                   {"height", kCount},
                   {"classes", described(listOf(kText), "names of classes, from 1")},
                   {"instances", listOf(instance)}});
}

ordered_json rendererSchema() {
    const ordered_json renderer =
        object({{"worker", described(kCount, "as in Clerestory-Worker; 0: it is being started")},
                {"warm", described(kFlag, "shaders of the default scene are compiled")},
                {"scenes", described(kCount, "loaded scenes")}});
    const ordered_json shaders =
        object({{"programs", described(kCount, "compiled programs")},
                {"pipelines", described(kCount, "programs with fixed state and a target format")},
                {"compileSeconds", kNumber},
                {"optimized", kFlag}});
    const ordered_json limits =
        object({{"edge", described(kCount, "maximum width and height")},
                {"pixels", described(kCount, "maximum number of pixels")},
                {"bodyBytes", kCount},
                {"sequenceBytes", kCount},
                {"uploadBytes", described(kCount, "0: uploads are off")},
                {"frameCacheBytes", described(kCount,
                                              "memory of frames that answer equal "
                                              "requests; 0: none")},
                {"queue", described(kCount, "frames that may wait")},
                {"deadlineSeconds", kNumber}});
    return object(
        {{"vendor", kText},
         {"renderer", kText},
         {"version", kText},
         {"shadingLanguage", kText},
         {"platform", kText},
         {"device", described({{"type", {"integer", "null"}}},
                              "index of the EGL device that --device selected")},
         {"software", described(kFlag, "the driver renders on the processor")},
         {"clipControl", described(kFlag, "depth can run from 1 to 0")},
         {"timerQueriesTrusted", described(kFlag, "milliseconds are measured by the GPU")},
         {"tellsOfResets", described(kFlag, "the driver reports resets of the GPU")},
         {"maxAnisotropy", kCount},
         {"maxTextureSize", kCount},
         {"shaders", shaders},
         {"environments",
          described(listOf(kText), "names of the environment maps, without uploads")},
         {"threads", described(kCount, "processors")},
         {"limits", limits},
         {"importer",
          object({{"landlock", described(kCount, "version of the ABI; 0: not available")},
                  {"systemCallFilter", described(kFlag, "seccomp is active")}})},
         {"confinement",
          object({{"landlock", described(kCount, "of the renderer's process; 0: none")},
                  {"systemCallFilter", described(kFlag, "seccomp is active")}})},
         {"program",
          object({{"version", kText}, {"build", described(kText, "hash of the program")}})}},
        {{"renderers", described(listOf(renderer), "only of a server with several renderers")}});
}

}  // namespace

ordered_json responseSchemas() {
    const ordered_json map = {{"name", described(kText, "as environment.map of a frame")},
                              {"title", kText},
                              {"source", oneOf({"builtIn", "file", "uploaded"})}};
    ordered_json wholeMap = map;
    wholeMap.update(
        {{"faceSize", described(kCount, "texels along the edge of a cube face")},
         {"meanRadiance", described(kNumber, "over all directions, of the brightest channel")},
         {"sun", described(kFlag, "it has a sun, which lights like a lamp")}});
    return {{"Problem", problemSchema()},
            {"Job", jobSchema()},
            {"Comparison", comparisonSchema()},
            {"AccuracyCurve", curveSchema()},
            {"Plan", planSchema()},
            {"Scene", sceneSchema()},
            {"SceneList", object({{"scenes", listOf(summarySchema())}})},
            {"EnvironmentList", object({{"environments", listOf(object(map))}})},
            {"Environment", object(wholeMap)},
            {"Renderer", rendererSchema()},
            {"Instances", instancesSchema()},
            {"Status", object({{"status", kText}})}};
}

}  // namespace clerestory
