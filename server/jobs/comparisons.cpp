#include "server/jobs/comparisons.h"

#include "image/image.h"
#include "measures/errors.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// 29 megabytes each at 1280 x 720.
constexpr std::size_t kMaxReferences = 4;
// Of a comparison's progress: tracing takes most of its time.
constexpr double kTracingShare = 0.7;

// Everything that changes a bit of the reference.
std::string referenceKey(const JobResources& resources, const ComparisonRequest& request) {
    FrameRequest frame = request.frame;
    frame.accuracy = {};
    frame.output = {};
    frame.toneMap = {};
    frame.exposure = 0.0;
    return resources.contentText(frame) + '\n' + std::to_string(static_cast<int>(request.mode)) +
           '\n' + std::to_string(request.samples) + '\n' + std::to_string(request.seed);
}

// With the exposure and the tone mapping of the request's frame.
Image displayedReference(const ReferenceRender& reference, const FrameRequest& frame) {
    const auto factor = static_cast<float>(std::exp2(frame.exposure));
    return quantised(displayed(reference.image.color, frame.toneMap, factor));
}

// The pictures of the errors in the order of the settings, then that of the reference.
JobResult resultOf(Comparison comparison, const Image& reference) {
    JobResult result;
    for (SettingResult& setting : comparison.settings) {
        if (setting.errorPicture.data.empty()) continue;
        result.pictures.push_back({"image/png", encodePng(setting.errorPicture)});
        setting.errorPicture = {};
    }
    if (!result.pictures.empty()) {
        result.pictures.push_back({"image/png", encodePng(reference)});
    }
    result.value = std::move(comparison);
    return result;
}

}  // namespace

std::shared_ptr<const ReferenceRender> ReferenceCache::find(
    const std::string& key, const std::function<std::shared_ptr<const ReferenceRender>()>& trace) {
    {
        const std::lock_guard lock(mutex_);
        const auto found = std::find_if(entries_.begin(), entries_.end(),
                                        [&](const Entry& e) { return e.key == key; });
        if (found != entries_.end()) {
            entries_.splice(entries_.begin(), entries_, found);
            return entries_.front().reference;
        }
    }
    const std::shared_ptr<const ReferenceRender> reference = trace();
    if (!reference) return nullptr;
    const std::lock_guard lock(mutex_);
    entries_.push_front({key, reference});
    if (entries_.size() > kMaxReferences) entries_.pop_back();
    return reference;
}

JobStatus Comparisons::start(const ComparisonRequest& request, const std::string& client,
                             const std::string& knownId) {
    const auto work = [this, request](const std::string&) {
        return [this, request](const JobControl& control) { return run(request, control); };
    };
    return jobs_.start(work, client, knownId);
}

JobResult Comparisons::run(const ComparisonRequest& request, const JobControl& control) {
    const auto known = resources_.library.require(request.frame.scene);
    const auto parts = resources_.library.requireParts(request.frame);  // not evicted meanwhile
    std::optional<Scene> whole;
    const auto reference = references_.find(referenceKey(resources_, request), [&] {
        whole = wholeScene(resources_.library, request.frame);
        return traceReference(resources_.library.environments(), *whole, request.frame,
                              request.mode, request.samples, request.seed,
                              [&](double share) { return control.proceed(kTracingShare * share); });
    });
    if (!reference) return {};
    // A single scene is known without its texels; a list is in one only here.
    if (parts.empty()) {
        whole.reset();
    } else if (!whole) {
        whole = wholeScene(resources_.library, request.frame);
    }
    try {
        auto comparison = compare(
            request, whole ? *whole : *known, *reference,
            [&](const FrameRequest& frame) { return drawInQueue(resources_, frame, control); },
            [&](double share) {
                return control.proceed(kTracingShare + (1.0 - kTracingShare) * share);
            });
        if (!comparison) return {};
        return resultOf(*std::move(comparison), displayedReference(*reference, request.frame));
    } catch (const JobCancelled&) {
        return {};
    }
}

}  // namespace clerestory
