// Presets, and the rules that bind several fields of a request together.
#include "plan/request/frame_request.h"

#include <cmath>

namespace clerestory {

// Chosen from docs/accuracy_presets.csv, which says on what machine; docs/accuracy.md says why.
Accuracy accuracyOf(Preset preset) {
    Accuracy a;
    a.preset = preset;
    switch (preset) {
        case Preset::draft:
            a.edgeFilter = false;
            a.environmentSize = 64;
            a.environmentSamples = 16;
            a.planarSamples = 1;
            a.generations = 1;
            a.probeSize = 128;
            a.probeSamples = 8;
            a.curvedSamples = 0;
            a.bounces = 2;
            a.glassRaySamples = 1;
            break;
        case Preset::standard:
            break;
        case Preset::fine:
            a.samples = 6;
            a.planarSamples = 8;
            a.curvedSamples = 6;
            a.backFaces = true;
            a.parallax = Parallax::depth;
            a.bounces = 8;
            a.raySamples = 4;
            break;
    }
    return a;
}

namespace {

std::string joined(const std::vector<FieldError>& errors) {
    std::string text;
    for (const FieldError& e : errors) {
        text += (text.empty() ? "" : "; ") + e.pointer + ": " + e.detail;
    }
    return text.empty() ? "invalid request" : text;
}

double length(const std::array<double, 4>& q) {
    return std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

// How far from 1 a unit quaternion or a rotation's rows may be: a client's rounding to float.
constexpr double kUnitTolerance = 1e-3;

bool isRigid(const std::array<double, 16>& m) {
    const glm::dvec3 x(m[0], m[1], m[2]), y(m[4], m[5], m[6]), z(m[8], m[9], m[10]);
    const auto near = [](double value, double wanted) {
        return std::abs(value - wanted) <= kUnitTolerance;
    };
    return near(glm::dot(x, x), 1) && near(glm::dot(y, y), 1) && near(glm::dot(z, z), 1) &&
           near(glm::dot(x, y), 0) && near(glm::dot(y, z), 0) && near(glm::dot(z, x), 0) &&
           glm::dot(glm::cross(x, y), z) > 0 && near(m[3], 0) && near(m[7], 0) && near(m[11], 0) &&
           near(m[15], 1);
}

void checkPose(const CameraRequest& c, std::vector<FieldError>& errors) {
    const auto refuse = [&](const char* pointer, const char* detail, const char* allowed) {
        errors.push_back({pointer, detail, allowed});
    };
    const char* onePose =
        "one of: position + target (+ up), position + orientation, cameraToWorld, name, fit, or "
        "nothing";
    if (c.fit && (c.cameraToWorld || c.position || c.target || c.up || c.orientation || c.name)) {
        refuse("/camera/fit", "conflicts with another form of the pose", onePose);
    }
    if (c.fit && c.orthographicHeight) {
        refuse("/camera/orthographicHeight", "conflicts with fit", "fit with yfov or intrinsics");
    }
    if (c.fit && c.lens && !std::holds_alternative<PerspectiveLens>(*c.lens)) {
        refuse("/camera/fit", "requires a perspective lens", "fit with lens perspective or none");
    }
    if (c.cameraToWorld && (c.position || c.target || c.up || c.orientation || c.name)) {
        refuse("/camera/cameraToWorld", "conflicts with another form of the pose", onePose);
    }
    if (c.name && (c.position || c.target || c.up || c.orientation)) {
        refuse("/camera/name", "conflicts with another form of the pose", onePose);
    }
    if (c.target && c.orientation) {
        refuse("/camera/orientation", "conflicts with target", onePose);
    }
    if (c.position && !c.target && !c.orientation) {
        refuse("/camera/position", "requires target or orientation", onePose);
    }
    if (!c.position && (c.target || c.orientation)) {
        refuse(c.target ? "/camera/target" : "/camera/orientation", "requires position", onePose);
    }
    if (c.up && !c.target) {
        refuse("/camera/up", "requires target", onePose);
    }
    if (c.position && c.target && *c.position == *c.target) {
        refuse("/camera/target", "equals position", "a different point");
    }
    if (c.up && *c.up == glm::dvec3(0.0)) {
        refuse("/camera/up", "has zero length", "a direction");
    }
    if (c.orientation && std::abs(length(*c.orientation) - 1.0) > kUnitTolerance) {
        refuse("/camera/orientation", "is not a unit quaternion", "x y z w with length 1");
    }
    if (c.cameraToWorld && !isRigid(*c.cameraToWorld)) {
        refuse("/camera/cameraToWorld", "is not a rigid transform",
               "column-major, orthonormal, determinant 1, last row 0 0 0 1");
    }
    if (c.convention == Convention::opencv && !c.cameraToWorld) {
        refuse("/camera/convention", "requires cameraToWorld", "opengl, or give cameraToWorld");
    }
}

void checkLens(const CameraRequest& c, std::vector<FieldError>& errors) {
    if (c.yfov && c.intrinsics) {
        errors.push_back({"/camera/intrinsics", "conflicts with yfov", "one of the two"});
    }
    if (c.orthographicHeight && (c.yfov || c.intrinsics || c.lens)) {
        errors.push_back({"/camera/orthographicHeight", "conflicts with another lens",
                          "one of yfov, orthographicHeight, intrinsics and lens"});
    }
    if (!c.lens || std::holds_alternative<PerspectiveLens>(*c.lens)) return;
    const std::string lens = "conflicts with the lens " + std::string(typeOf(*c.lens));
    if (c.yfov) errors.push_back({"/camera/yfov", lens, "yfov with lens perspective or none"});
    if (c.intrinsics && !std::holds_alternative<FisheyeLens>(*c.lens)) {
        errors.push_back(
            {"/camera/intrinsics", lens, "intrinsics with lens perspective, fisheye or none"});
    }
}

void checkFormat(const Output& output, std::vector<FieldError>& errors) {
    const bool json = output.format == OutputFormat::json;
    const bool floats = output.format == OutputFormat::npy || output.format == OutputFormat::exr;
    const char* detail = "cannot hold this channel";
    if (output.channel == Channel::instances) {
        if (!json) errors.push_back({"/output/format", detail, "json"});
    } else if (output.channel != Channel::color) {
        if (!floats) errors.push_back({"/output/format", detail, "npy or exr"});
    } else if (json) {
        errors.push_back({"/output/format", detail, "jpeg, png, webp, npy or exr"});
    }
}

std::vector<FieldError> cameraProblems(const CameraRequest& c) {
    std::vector<FieldError> errors;
    checkPose(c, errors);
    checkLens(c, errors);
    if (c.znear && c.zfar && !(*c.znear < *c.zfar)) {
        errors.push_back({"/camera/zfar", "is not greater than znear", "more than znear"});
    }
    return errors;
}

}  // namespace

std::vector<FieldError> below(const std::string& pointer, std::vector<FieldError> errors) {
    for (FieldError& e : errors) e.pointer = pointer + e.pointer;
    return errors;
}

InvalidRequest::InvalidRequest(std::vector<FieldError> errors)
    : std::runtime_error(joined(errors)), errors_(std::move(errors)) {}

bool isTransparent(const std::optional<BackgroundRequest>& background) {
    return background && *background == BackgroundRequest(Background::transparent);
}

Composition compositionOf(const FrameRequest& request) {
    Composition composition{request.nodes, request.variant, request.ground};
    if (request.ground) {
        composition.shadowCatcher =
            request.ground->shadowCatcher.value_or(isTransparent(request.background));
    }
    return composition;
}

std::vector<FieldError> problems(const FrameRequest& request) {
    std::vector<FieldError> errors = problems(request.parts);
    for (FieldError& e : cameraProblems(request.camera)) errors.push_back(std::move(e));
    if (const auto& flow = request.output.flow; flow && flow->camera) {
        for (FieldError& e : below("/output/flow", cameraProblems(*flow->camera))) {
            errors.push_back(std::move(e));
        }
    }
    if (std::uint64_t{request.width} * request.height > kMaxPixels) {
        errors.push_back({"/width", "width x height is too large",
                          "at most " + std::to_string(kMaxPixels) + " pixels"});
    }
    if (request.environment.rotation && !isUnit(*request.environment.rotation)) {
        errors.push_back({"/environment/rotation", "is not a rotation", kRotationForms});
    }
    Accuracy knobs = request.accuracy;
    knobs.maxMilliseconds = knobs.maxError = std::nullopt;
    if (request.accuracy.isBudget() && knobs != Accuracy{}) {
        errors.push_back({"/accuracy", "has settings together with a budget, which replaces them",
                          "maxMilliseconds, maxError or both; or a preset and settings"});
    }
    checkFormat(request.output, errors);
    if (request.output.layer != OutputLayer::direct && !hasLayers(request.output.channel)) {
        errors.push_back({"/output/layer", "conflicts with this channel",
                          "direct; or another one with channels other than color and through"});
    }
    if (request.output.channel == Channel::classId && request.output.classes.empty()) {
        errors.push_back(
            {"/output/classes", "is empty", "a list of { name, pattern } for the channel classId"});
    }
    if (request.output.channel == Channel::flow && !request.output.flow) {
        errors.push_back({"/output/flow", "is missing", "{ time, camera } for the channel flow"});
    }
    if (request.output.channel == Channel::color && request.output.format == OutputFormat::jpeg &&
        isTransparent(request.background)) {
        errors.push_back(
            {"/output/format", "cannot hold a transparent background", "png, webp, exr or npy"});
    }
    return errors;
}

}  // namespace clerestory
