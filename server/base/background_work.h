// Work of a process that no client waits for, by name, such as compiling programs in advance. The
// server learns which of it is in progress when the process ends, and has the next one leave it
// out.
//
//     BackgroundWork work(leftOut, report);
//     if (const auto part = work.begin("light of chapel")) compute();
//
// Thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace clerestory {

class BackgroundWork {
public:
    // Called when work begins and when it ends, on its thread. `number`: of this piece of work.
    using Report = std::function<void(std::uint64_t number, const std::string& name, bool begins)>;

    // `leftOut`: names of work that does not begin.
    explicit BackgroundWork(std::vector<std::string> leftOut = {}, Report report = {});
    ~BackgroundWork();
    BackgroundWork(const BackgroundWork&) = delete;
    BackgroundWork& operator=(const BackgroundWork&) = delete;

    // The work is in progress until the last copy of the result is destroyed, which may be after
    // this object. Null if it is left out.
    std::shared_ptr<const void> begin(const std::string& name);

private:
    struct Shared;
    const std::shared_ptr<Shared> shared_;
};

}  // namespace clerestory
