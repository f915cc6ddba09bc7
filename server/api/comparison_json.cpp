#include "server/api/comparison_json.h"

#include "scene/import/base/field_reader.h"
#include "server/api/frame_json.h"

#include <nlohmann/json.hpp>

#include <cstdio>

namespace clerestory {
namespace {

using nlohmann::ordered_json;

ordered_json linearJson(const LinearErrors& e) {
    ordered_json json = {{"pixels", e.pixels},
                         {"relMse", e.relMse},
                         {"relMseTrimmed", e.relMseTrimmed},
                         {"rmse", e.rmse},
                         {"bias", e.bias},
                         {"p95", e.p95},
                         {"meanReference", e.meanReference}};
    if (e.nonFinite > 0) json["nonFinite"] = e.nonFinite;
    return json;
}

ordered_json settingJson(const SettingResult& s) {
    ordered_json frame = linearJson(s.frame);
    frame["psnr"] = s.displayed.psnr;
    frame["ssim"] = s.displayed.ssim;
    frame["flip"] = s.displayed.flip;
    frame["decibels"] = s.displayed.decibels;
    frame["modelDecibels"] = s.modelDecibels;
    ordered_json error = {{"frame", std::move(frame)}};
    for (const EffectErrors& e : s.effects) {
        ordered_json one = linearJson(e.errors);
        one["relMseOff"] = e.relMseOff;
        one["relMseNoise"] = e.relMseNoise;
        one["closedGap"] = e.closedGap;
        error[std::string(nameOf(e.effect))] = std::move(one);
    }
    return {{"name", s.name},
            {"accuracy", accuracyJson(s.accuracy)},
            {"milliseconds",
             {{"cold", s.coldMs},
              {"median", s.medianMs},
              {"p95", s.p95Ms},
              {"predictedForEffects", s.predictedMs}}},
            {"counts",
             {{"passes", s.totals.passes},
              {"views", s.totals.views},
              {"draws", s.totals.draws},
              {"triangles", s.totals.triangles}}},
            {"error", std::move(error)},
            {"closedGap", s.closedGap},
            {"jpeg", {{"psnr", s.jpegPsnr}}}};
}

}  // namespace

ComparisonRequest comparisonRequestFrom(const nlohmann::json& body) {
    std::vector<FieldError> errors;
    ComparisonRequest request;
    FieldReader(errors).object(body, request, "");
    if (errors.empty()) errors = problems(request);
    if (!errors.empty()) throw RequestError(invalidFields(std::move(errors)));
    return request;
}

ordered_json comparisonJson(const Comparison& c, const std::vector<std::string>& pictures) {
    ordered_json settings = ordered_json::array();
    for (std::size_t i = 0; i < c.settings.size(); ++i) {
        settings.push_back(settingJson(c.settings[i]));
        if (i < pictures.size()) settings.back()["errorPicture"] = pictures[i];
    }
    return {{"reference",
             {{"mode", c.mode == ReferenceMode::full ? "full" : "effects"},
              {"samples", c.samples},
              {"seed", c.seed},
              {"milliseconds", c.truthMs},
              {"noise", {{"relMse", c.relMseNoise}}},
              {"nonFinite", c.nonFinite}}},
            {"effectsOff", {{"relMse", c.relMseOff}}},
            {"settings", std::move(settings)}};
}

ordered_json curveJson(const Curve& curve) {
    ordered_json points = ordered_json::array();
    for (const CurvePoint& p : curve.points) {
        points.push_back({{"name", nameOf(p.accuracy)},
                          {"accuracy", accuracyJson(p.accuracy)},
                          {"milliseconds", p.milliseconds},
                          {"relMse", p.relMse}});
    }
    return {{"noise", {{"relMse", curve.relMseNoise}}}, {"points", std::move(points)}};
}

std::string comparisonTable(const Comparison& c) {
    std::string text =
        "| setting | ms | p95 | relMSE | trimmed | PSNR | SSIM | FLIP | dB | dB of the scene | "
        "closed gap | "
        "relMSE of each "
        "effect (closed gap) |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    char line[512];
    for (const SettingResult& s : c.settings) {
        std::string effects;
        for (const EffectErrors& e : s.effects) {
            std::snprintf(line, sizeof line, "%s%s %.3g (%.0f %%)", effects.empty() ? "" : ", ",
                          std::string(nameOf(e.effect)).c_str(), e.errors.relMse,
                          100.0 * e.closedGap);
            effects += line;
        }
        std::snprintf(
            line, sizeof line,
            "| %s | %.1f | %.1f | %.3g | %.3g | %.1f | %.3f | %.3f | %.1f | %.1f | %.0f %% | ",
            s.name.c_str(), s.medianMs, s.p95Ms, s.frame.relMse, s.frame.relMseTrimmed,
            s.displayed.psnr, s.displayed.ssim, s.displayed.flip, s.displayed.decibels,
            s.modelDecibels, 100.0 * s.closedGap);
        text += line + effects + " |\n";
    }
    std::snprintf(line, sizeof line,
                  "\nReference: %u paths per pixel in %.1f s, noise relMSE %.2g; with all effects "
                  "off %.3g.\n",
                  c.samples, c.truthMs / 1000.0, c.relMseNoise, c.relMseOff);
    return text + line;
}

}  // namespace clerestory
