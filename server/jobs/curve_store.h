// Measured curves on the disk, so that a budget need not wait again after a worker or a server has
// ended. Whatever is damaged or cut short is as good as not there. Thread-safe; any number of
// processes may share a folder.
#pragma once

#include "comparison/curve.h"

#include <filesystem>
#include <optional>
#include <string>

namespace clerestory {

class CurveStore {
public:
    explicit CurveStore(std::filesystem::path folder) : folder_(std::move(folder)) {}

    // key: all that a curve depends on, the program and the driver included.
    std::optional<Curve> find(const std::string& key) const;
    // Of ladder(). What cannot be kept is not kept. Curves that were used longest ago give way.
    void keep(const std::string& key, const Curve& curve) const;

private:
    std::filesystem::path fileOf(const std::string& key) const;

    const std::filesystem::path folder_;
};

}  // namespace clerestory
