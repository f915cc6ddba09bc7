#include "plan/visibility/camera_path.h"

#include "plan/visibility/view.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// The numbers of a key that move; a vector so that one formula moves all of them.
struct Moving {
    glm::dvec3 position{0.0};
    glm::dvec3 target{0.0}, up{0.0, 1.0, 0.0};
    glm::dvec4 turn{0.0, 0.0, 0.0, 1.0};  // quaternion x y z w
    double yfov = 0.0;
    bool looksAt = false;

    Moving operator+(const Moving& o) const {
        return {position + o.position, target + o.target, up + o.up, turn + o.turn, yfov + o.yfov};
    }
    Moving operator*(double s) const {
        return {position * s, target * s, up * s, turn * s, yfov * s};
    }
};

bool hasPose(const CameraRequest& c) {
    return c.cameraToWorld || c.position;
}

Moving movingOf(const CameraRequest& camera) {
    const glm::dmat4 worldFromCamera = *worldFromPose(camera);
    const glm::dquat q = glm::quat_cast(glm::dmat3(worldFromCamera));
    return {.position = glm::dvec3(worldFromCamera[3]),
            .target = camera.target.value_or(glm::dvec3(0.0)),
            .up = glm::normalize(camera.up.value_or(glm::dvec3(0.0, 1.0, 0.0))),
            .turn = {q.x, q.y, q.z, q.w},
            .yfov = camera.yfov.value_or(kDefaultYfov),
            .looksAt = camera.target.has_value()};
}

CameraRequest cameraAt(const Moving& at, const CameraRequest& before, bool looksAt) {
    CameraRequest camera;
    camera.intrinsics = before.intrinsics;
    camera.lens = before.lens;
    camera.orthographicHeight = before.orthographicHeight;
    camera.znear = before.znear;
    camera.zfar = before.zfar;
    const bool perspective =
        !camera.orthographicHeight &&
        (!camera.lens || std::holds_alternative<PerspectiveLens>(*camera.lens));
    if (perspective && !camera.intrinsics) camera.yfov = at.yfov;
    camera.position = at.position;
    if (looksAt) {
        camera.target = at.target;
        if (glm::length(at.up) > 1e-6) camera.up = glm::normalize(at.up);
    } else {
        const glm::dvec4 q = glm::normalize(at.turn);
        camera.orientation = {q.x, q.y, q.z, q.w};
    }
    return camera;
}

// s in 0..1 from p to q; slopes are per that unit.
Moving hermite(const Moving& p, const Moving& q, const Moving& slopeP, const Moving& slopeQ,
               double s) {
    const double s2 = s * s, s3 = s2 * s;
    return p * (2 * s3 - 3 * s2 + 1) + slopeP * (s3 - 2 * s2 + s) + q * (3 * s2 - 2 * s3) +
           slopeQ * (s3 - s2);
}

class Curve {
public:
    explicit Curve(const CameraPath& path) : path_(path) {
        for (const CameraKey& key : path.keys) {
            Moving at = movingOf(key.camera);
            // q and -q are one turn; the nearer one makes the shorter way.
            if (!keys_.empty() && glm::dot(keys_.back().turn, at.turn) < 0.0) at.turn = -at.turn;
            keys_.push_back(at);
        }
    }

    CameraRequest at(double time) const {
        const std::size_t last = keys_.size() - 1;
        if (last == 0) return path_.keys[0].camera;
        const auto after =
            std::upper_bound(path_.keys.begin(), path_.keys.end(), time,
                             [](double t, const CameraKey& key) { return t < key.time; });
        const std::size_t i = std::min<std::size_t>(
            last - 1,
            static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, after - path_.keys.begin() - 1)));
        const double span = path_.keys[i + 1].time - path_.keys[i].time;
        const double s = std::clamp((time - path_.keys[i].time) / span, 0.0, 1.0);
        const bool looksAt = keys_[i].looksAt && keys_[i + 1].looksAt;
        return cameraAt(
            path_.interpolation == PathInterpolation::smooth
                ? hermite(keys_[i], keys_[i + 1], slope(i) * span, slope(i + 1) * span, s)
                : straight(i, s),
            path_.keys[i].camera, looksAt);
    }

private:
    Moving straight(std::size_t i, double s) const {
        Moving at = keys_[i] * (1.0 - s) + keys_[i + 1] * s;
        const auto quaternion = [](const glm::dvec4& v) { return glm::dquat(v.w, v.x, v.y, v.z); };
        const glm::dquat q =
            glm::slerp(quaternion(keys_[i].turn), quaternion(keys_[i + 1].turn), s);
        at.turn = {q.x, q.y, q.z, q.w};
        return at;
    }

    Moving slope(std::size_t i) const {  // per second
        const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, keys_.size() - 1);
        const double span = path_.keys[after].time - path_.keys[before].time;
        return (keys_[after] + keys_[before] * -1.0) * (1.0 / span);
    }

    const CameraPath& path_;
    std::vector<Moving> keys_;
};

}  // namespace

std::vector<FieldError> problems(const CameraPath& path) {
    std::vector<FieldError> errors;
    if (path.keys.empty()) errors.push_back({"/keys", "is empty", "at least one key"});
    for (std::size_t i = 0; i < path.keys.size(); ++i) {
        const std::string pointer = "/keys/" + std::to_string(i);
        FrameRequest alone;
        alone.camera = path.keys[i].camera;
        const auto wrong = problems(alone);
        for (FieldError error : wrong) {
            error.pointer = pointer + error.pointer;
            errors.push_back(std::move(error));
        }
        if (wrong.empty() && !hasPose(path.keys[i].camera)) {
            errors.push_back({pointer + "/camera", "has no pose",
                              "position with target or orientation, or cameraToWorld"});
        }
        if (i > 0 && path.keys[i].time <= path.keys[i - 1].time) {
            errors.push_back(
                {pointer + "/time", "is not later than the previous key", "ascending times"});
        }
    }
    return errors;
}

double frameCount(const CameraPath& path) {
    if (path.keys.empty()) return 0.0;
    // A billionth of a frame of rounding does not lose the last one.
    return std::floor((path.keys.back().time - path.keys.front().time) * path.frameRate + 1e-9) +
           1.0;
}

std::vector<PathFrame> framesOf(const CameraPath& path) {
    const Curve curve(path);
    std::vector<PathFrame> frames(static_cast<std::size_t>(frameCount(path)));
    for (std::size_t i = 0; i < frames.size(); ++i) {
        frames[i].time = path.keys.front().time + static_cast<double>(i) / path.frameRate;
        frames[i].camera = curve.at(frames[i].time);
    }
    return frames;
}

}  // namespace clerestory
