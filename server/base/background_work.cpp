#include "server/base/background_work.h"

#include "server/base/log.h"

#include <algorithm>
#include <atomic>

namespace clerestory {

struct BackgroundWork::Shared {
    Shared(std::vector<std::string> names, Report to)
        : leftOut(std::move(names)), report(std::move(to)) {}

    const std::vector<std::string> leftOut;
    const Report report;
    std::atomic<std::uint64_t> next{1};
};

BackgroundWork::BackgroundWork(std::vector<std::string> leftOut, Report report)
    : shared_(std::make_shared<Shared>(std::move(leftOut), std::move(report))) {}

BackgroundWork::~BackgroundWork() = default;

std::shared_ptr<const void> BackgroundWork::begin(const std::string& name) {
    const auto& out = shared_->leftOut;
    if (std::find(out.begin(), out.end(), name) != out.end()) {
        logWarning({name, ": left out, since renderers ended during it"});
        return nullptr;
    }
    struct Part {
        Part(std::shared_ptr<Shared> owner, std::string name)
            : owner_(std::move(owner)), name_(std::move(name)), number_(owner_->next++) {
            if (owner_->report) owner_->report(number_, name_, true);
        }
        ~Part() {
            if (owner_->report) owner_->report(number_, name_, false);
        }
        Part(const Part&) = delete;
        Part& operator=(const Part&) = delete;

        const std::shared_ptr<Shared> owner_;
        const std::string name_;
        const std::uint64_t number_;
    };
    return std::make_shared<const Part>(shared_, name);
}

}  // namespace clerestory
