// Path-traced pictures, kept by what they show: a comparison of other settings of the same view
// waits for nothing. Thread-safe.
#pragma once

#include "comparison/comparison.h"

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>

namespace clerestory {

class ReferenceCache {
public:
    // The truth under `key`, or what `trace` makes, which is kept; null when that is null, which is
    // not.
    std::shared_ptr<const ReferenceRender> find(
        const std::string& key,
        const std::function<std::shared_ptr<const ReferenceRender>()>& trace);

private:
    struct Kept {
        std::string key;
        std::shared_ptr<const ReferenceRender> truth;
    };
    std::mutex mutex_;
    std::list<Kept> kept_;  // latest used first
};

}  // namespace clerestory
