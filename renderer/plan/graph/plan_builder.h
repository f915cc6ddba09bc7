// Builds a plan: targets, passes, decisions and omissions. A transaction removes everything that
// was added since it began, unless it is committed.
//
//     PlanBuilder builder(plan);
//     PlanBuilder::Transaction capture(builder);
//     ... builder.addTarget(...), builder.addPass(...) ...
//     if (isResident(hashOfPasses(plan, capture.ownPasses(), ...))) return;  // rolls back
//     capture.commit(target, key);
#pragma once

#include "plan/graph/frame_plan.h"

#include <map>
#include <optional>

namespace clerestory {

class PlanBuilder {
public:
    // `plan` must outlive the builder.
    explicit PlanBuilder(FramePlan& plan) : plan_(plan) {}
    PlanBuilder(const PlanBuilder&) = delete;
    PlanBuilder& operator=(const PlanBuilder&) = delete;

    const FramePlan& plan() const { return plan_; }
    const TargetSpec& target(TargetId id) const { return plan_.targets[id]; }

    TargetId addTarget(TargetSpec spec);
    void addPass(Pass pass);
    void addDecision(Decision decision);
    void skip(const Subject& subject, Effect effect, std::string reason);

    // Number of decisions and omissions so far; truncateExplanations() removes later ones.
    struct Explanations {
        std::size_t decisions, skipped;
    };
    Explanations explanations() const { return {plan_.decisions.size(), plan_.skipped.size()}; }
    void truncateExplanations(const Explanations& to) {
        plan_.decisions.resize(to.decisions);
        plan_.skipped.resize(to.skipped);
    }

    // Targets that several views read, by a key that identifies them within the frame.
    std::optional<TargetId> shared(std::uint64_t key) const;
    void share(std::uint64_t key, TargetId target);
    // Makes a scratch target at least that large, in texels.
    void enlarge(TargetId scratch, std::uint32_t width, std::uint32_t height);

    class Transaction;

private:
    FramePlan& plan_;
    std::map<std::uint64_t, TargetId> shared_;
    std::vector<std::uint64_t> sharedInOrder_;
    // The passes [first, end) of committed transactions; ascending and disjoint.
    std::vector<std::pair<std::size_t, std::size_t>> keyedPasses_;
};

// The passes of one map. Transactions nest.
class PlanBuilder::Transaction {
public:
    explicit Transaction(PlanBuilder& builder);
    ~Transaction();  // rolls back unless committed
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;

    // Indices of the passes added since, without those of nested committed transactions: the key of
    // a map must not depend on whether the maps that it reads had to be drawn.
    std::vector<std::size_t> ownPasses() const;

    // Keeps everything. `residentKey` identifies the content of the finished map in `target`.
    void commit(TargetId target, std::uint64_t residentKey);

private:
    PlanBuilder& builder_;
    std::size_t passes_, targets_, skipped_, decisions_, shared_, keyedPasses_;
    bool committed_ = false;
};

}  // namespace clerestory
