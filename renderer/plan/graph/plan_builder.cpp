#include "plan/graph/plan_builder.h"

#include <algorithm>

namespace clerestory {

TargetId PlanBuilder::addTarget(TargetSpec spec) {
    plan_.targets.push_back(std::move(spec));
    return static_cast<TargetId>(plan_.targets.size() - 1);
}

void PlanBuilder::addPass(Pass pass) {
    plan_.passes.push_back(std::move(pass));
}

void PlanBuilder::addDecision(Decision decision) {
    plan_.decisions.push_back(std::move(decision));
}

void PlanBuilder::skip(const Subject& subject, Effect effect, std::string reason) {
    plan_.skipped.push_back({nameOf(subject), effect, std::move(reason), subject});
}

std::optional<TargetId> PlanBuilder::shared(std::uint64_t key) const {
    const auto found = shared_.find(key);
    return found == shared_.end() ? std::nullopt : std::optional(found->second);
}

void PlanBuilder::share(std::uint64_t key, TargetId target) {
    if (shared_.emplace(key, target).second) sharedInOrder_.push_back(key);
}

void PlanBuilder::enlarge(TargetId scratch, std::uint32_t width, std::uint32_t height) {
    TargetSpec& spec = plan_.targets[scratch];
    spec.width = std::max(spec.width, width);
    spec.height = std::max(spec.height, height);
}

PlanBuilder::Transaction::Transaction(PlanBuilder& builder)
    : builder_(builder),
      passes_(builder.plan_.passes.size()),
      targets_(builder.plan_.targets.size()),
      skipped_(builder.plan_.skipped.size()),
      decisions_(builder.plan_.decisions.size()),
      shared_(builder.sharedInOrder_.size()),
      keyedPasses_(builder.keyedPasses_.size()) {}

PlanBuilder::Transaction::~Transaction() {
    if (committed_) return;
    builder_.plan_.passes.resize(passes_);
    builder_.plan_.targets.resize(targets_);
    builder_.plan_.skipped.resize(skipped_);
    builder_.plan_.decisions.resize(decisions_);
    builder_.keyedPasses_.resize(keyedPasses_);
    for (std::size_t i = shared_; i < builder_.sharedInOrder_.size(); ++i) {
        builder_.shared_.erase(builder_.sharedInOrder_[i]);
    }
    builder_.sharedInOrder_.resize(shared_);
}

std::vector<std::size_t> PlanBuilder::Transaction::ownPasses() const {
    std::vector<std::size_t> own;
    auto keyed = builder_.keyedPasses_.begin() + static_cast<std::ptrdiff_t>(keyedPasses_);
    const auto end = builder_.keyedPasses_.end();
    for (std::size_t i = passes_; i < builder_.plan_.passes.size(); ++i) {
        while (keyed != end && keyed->second <= i) ++keyed;
        if (keyed == end || i < keyed->first) own.push_back(i);
    }
    return own;
}

void PlanBuilder::Transaction::commit(TargetId target, std::uint64_t residentKey) {
    builder_.plan_.targets[target].residentKey = residentKey;
    builder_.keyedPasses_.resize(keyedPasses_);
    builder_.keyedPasses_.emplace_back(passes_, builder_.plan_.passes.size());
    committed_ = true;
}

}  // namespace clerestory
