#include "server/api/response_schemas.h"

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

// `always`: fields that every answer has; the others depend on what is described.
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
        object({{"pointer", described(kText, "RFC 6901")}, {"detail", kText}, {"allowed", kText}});
    return object({{"type", described(kText, "urn:clerestory:problem: followed by the code")},
                   {"code", described(kText, "stable identifier, such as queueFull")},
                   {"title", kText},
                   {"status", kCount}},
                  {{"detail", kText},
                   {"requestId", kText},
                   {"reason", kText},
                   {"errors", listOf(fieldError)}});
}

// JSON has no infinities: a measure that is not finite is null.
const ordered_json kMeasure = {{"type", {"number", "null"}}};
const ordered_json kAccuracy = {{"$ref", "#/components/schemas/Accuracy"}};

ordered_json linearErrors(ordered_json more) {
    ordered_json always = {{"pixels", kCount}, {"relMse", kMeasure}, {"rmse", kMeasure},
                           {"bias", kMeasure}, {"p95", kMeasure},    {"meanReference", kMeasure}};
    always.update(more);
    return object(std::move(always), {{"nonFinite", kCount}});
}

ordered_json comparisonSchema() {
    const ordered_json frame = linearErrors(
        {{"psnr", kMeasure}, {"ssim", kMeasure}, {"flip", kMeasure}, {"decibels", kMeasure}});
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
                                               {"environmentReflection", effect}})},
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
                  {{"failure", kText},
                   {"result", described({{"anyOf",
                                          {{{"$ref", "#/components/schemas/Comparison"}},
                                           {{"$ref", "#/components/schemas/AccuracyCurve"}}}}},
                                        "of a comparison, or of the measurement that a budget of "
                                        "accuracy needs")}});
}

ordered_json viewSchema() {
    return object({{"viewFromWorld", numbers(16)},
                   {"clipFromView", numbers(16)},
                   {"eye", numbers(3)},
                   {"znear", kNumber},
                   {"orthographic", kFlag},
                   {"mirrored", kFlag}},
                  {{"clipPlane", numbers(4)}});
}

ordered_json planSchema() {
    const ordered_json pass = object({{"kind", kText},
                                      {"name", kText},
                                      {"effect", kText},
                                      {"generation", kCount},
                                      {"views", kCount},
                                      {"draws", kCount},
                                      {"triangles", kCount},
                                      {"reads", listOf(kText)},
                                      {"reason", kText},
                                      {"viewMatrices", listOf(viewSchema())}},
                                     {{"target", kText},
                                      {"width", kCount},
                                      {"height", kCount},
                                      {"format", oneOf({"rgba16f", "rgba32f", "srgba8"})},
                                      {"samples", kCount},
                                      {"milliseconds", kNumber}});
    const ordered_json skipped = object({{"name", kText}, {"effect", kText}, {"reason", kText}});
    const ordered_json candidate =
        object({{"method", kText},
                {"milliseconds", described(kNumber, "predicted")},
                {"error", described(kNumber, "predicted, relative RMSE on its pixels")}});
    const ordered_json decision = object({{"name", kText},
                                          {"effect", kText},
                                          {"taken", kText},
                                          {"reason", kText},
                                          {"candidates", listOf(candidate)}});
    const ordered_json intrinsics = object({{"fx", kNumber},
                                            {"fy", kNumber},
                                            {"cx", kNumber},
                                            {"cy", kNumber},
                                            {"pixelCenter", oneOf({"half", "integer"})}});
    const ordered_json camera = object({{"cameraToWorld", numbers(16)},
                                        {"convention", oneOf({"opengl", "opencv"})},
                                        {"clipFromView", numbers(16)},
                                        {"width", kCount},
                                        {"height", kCount},
                                        {"znear", kNumber}},
                                       {{"intrinsics", intrinsics}});
    const ordered_json totals = object({{"passes", kCount},
                                        {"views", kCount},
                                        {"draws", kCount},
                                        {"triangles", kCount},
                                        {"samples", kCount}});
    return object({{"passes", listOf(pass)},
                   {"skipped", listOf(skipped)},
                   {"decisions", listOf(decision)},
                   {"totals", totals}},
                  {{"camera", camera}});
}

// An instance that glows, lets light through or mirrors.
ordered_json surface(ordered_json more) {
    ordered_json always = {{"objectId", described(kCount, "as in the channel of that name")},
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
    return {{"stage", described(kText, "while it loads")},
            {"progress", {{"type", "number"}, {"minimum", 0}, {"maximum", 1}}},
            {"uploaded", kFlag},
            {"failure", kText},
            {"reason", kText},
            {"triangles", kCount},
            {"bounds", bounds},
            {"effects", described(listOf(kText), "that the scene calls for")}};
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
    const ordered_json mirror = {{"roughness", kNumber}, {"reflectance", kNumber}};
    ordered_json flat = surface(mirror);
    flat["properties"]["normal"] = numbers(3);
    const ordered_json animation =
        object({{"name", kText}, {"duration", described(kNumber, "seconds")}, {"default", kFlag}});
    const ordered_json camera = object(
        {{"name", kText},
         {"position", numbers(3)},
         {"direction", numbers(3)},
         {"orthographic", kFlag}},
        {{"yfov", kNumber}, {"yHalfHeight", kNumber}, {"znear", kNumber}, {"zfar", kNumber}});
    const ordered_json light = object({{"name", kText},
                                       {"kind", oneOf({"point", "spot", "directional"})},
                                       {"intensity", numbers(3)}},
                                      {{"position", numbers(3)},
                                       {"direction", numbers(3)},
                                       {"range", kNumber},
                                       {"innerConeAngle", kNumber},
                                       {"outerConeAngle", kNumber}});
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
        object({{"code", kText}, {"subject", kText}, {"message", kText}, {"count", kCount}});
    const ordered_json glass =
        surface({{"kind", oneOf({"pane", "solid"})}, {"transmission", kNumber}, {"ior", kNumber}});
    return summarySchema(
        {{"defaultView",
          object({{"position", numbers(3)}, {"target", numbers(3)}, {"yfov", kNumber}})},
         {"environment", kText},
         {"environmentRotation", described(numbers(4), "world from map, x y z w")},
         {"counts", counts},
         {"memory", memory},
         {"animations", listOf(animation)},
         {"cameras", listOf(camera)},
         {"lights", listOf(light)},
         {"emitters", listOf(surface({{"radiance", numbers(3)}}))},
         {"glass", listOf(glass)},
         {"flatMirrors", listOf(flat)},
         {"curvedMirrors", listOf(surface(mirror))},
         {"probes", listOf(probe)},
         {"warnings", listOf(warning)},
         {"shaders", object({{"compiled", kCount}, {"total", kCount}, {"finished", kFlag}})}});
}

ordered_json rendererSchema() {
    const ordered_json shaders = object({{"programs", kCount},
                                         {"pipelines", kCount},
                                         {"compileSeconds", kNumber},
                                         {"optimized", kFlag}});
    const ordered_json limits = object({{"edge", kCount},
                                        {"pixels", kCount},
                                        {"bodyBytes", kCount},
                                        {"sequenceBytes", kCount},
                                        {"uploadBytes", described(kCount, "0: no uploads")},
                                        {"queue", kCount},
                                        {"deadlineSeconds", kNumber}});
    return object(
        {{"vendor", kText},
         {"renderer", kText},
         {"version", kText},
         {"shadingLanguage", kText},
         {"platform", kText},
         {"software", kFlag},
         {"clipControl", kFlag},
         {"timerQueriesTrusted", kFlag},
         {"tellsOfResets", kFlag},
         {"maxSamples", kCount},
         {"maxAnisotropy", kCount},
         {"maxTextureSize", kCount},
         {"shaders", shaders},
         {"environments", listOf(kText)},
         {"threads", kCount},
         {"limits", limits},
         {"importer", object({{"landlock", described(kCount, "version of the ABI; 0: none")},
                              {"systemCallFilter", kFlag}})},
         {"program", object({{"version", kText}, {"build", kText}})}});
}

}  // namespace

ordered_json responseSchemas() {
    return {{"Problem", problemSchema()},
            {"Job", jobSchema()},
            {"Comparison", comparisonSchema()},
            {"AccuracyCurve", curveSchema()},
            {"Plan", planSchema()},
            {"Scene", sceneSchema()},
            {"SceneList", object({{"scenes", listOf(summarySchema())}})},
            {"Renderer", rendererSchema()},
            {"Status", object({{"status", kText}})}};
}

}  // namespace clerestory
