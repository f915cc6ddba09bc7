// Accuracy by budget: the curve of a scene is measured when a budget first asks for it, as a job,
// and kept, on the disk too where there is a place; frames that ran correct its milliseconds.
// Thread-safe.
#pragma once

#include "comparison/curve.h"

#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace clerestory {

class Service;

class Budgets {
public:
    struct Pick {
        Accuracy accuracy;
        std::string words;  // for people: what it is, what was predicted, what was given up
        std::string curve;  // for drawn()
        std::size_t point = 0;
    };
    // What the request's budget comes to. The curve belongs to the scene, its overrides, light,
    // effects and size; the first view that asks stands for all. Throws RequestError 409 with the
    // job's place while it is measured, 503 when there is no room for another job.
    Pick pick(Service& service, const Scene& scene, const FrameRequest& request);

    // A frame of that pick took so long to draw.
    void drawn(Service& service, const Pick& pick, double milliseconds);

private:
    struct Measured {
        std::string job;  // that measures it, or did
        std::shared_ptr<Curve> curve;
        int corrected = 0;  // times since it was last kept on the disk
    };
    std::mutex mutex_;
    std::map<std::string, Measured> curves_;
};

}  // namespace clerestory
