// Writes a plan: targets, passes, decisions, and what was left out. What was added since a
// transaction began is taken back unless the transaction is committed.
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
    void skip(std::string name, Effect effect, std::string reason);

    // Targets that several views read, by a key of the caller's choice that identifies them within
    // the frame.
    std::optional<TargetId> shared(std::uint64_t key) const;
    void share(std::uint64_t key, TargetId target);

    class Transaction;

private:
    FramePlan& plan_;
    std::map<std::uint64_t, TargetId> shared_;
    std::vector<std::uint64_t> sharedInOrder_;
    // The passes [first, end) of maps that have a key of their own; ascending and disjoint.
    std::vector<std::pair<std::size_t, std::size_t>> keyedPasses_;
};

// The passes of one map. Transactions nest like scopes.
class PlanBuilder::Transaction {
public:
    explicit Transaction(PlanBuilder& builder);
    ~Transaction();  // takes back everything added since, unless committed
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;

    // The passes added since, by their index in the plan, without those of nested committed
    // transactions: whether a map that these passes read had to be drawn, and for whom, does not
    // count.
    std::vector<std::size_t> ownPasses() const;

    // Keeps everything. `target` holds the finished map, whose content is identified by
    // `residentKey`.
    void commit(TargetId target, std::uint64_t residentKey);

private:
    PlanBuilder& builder_;
    std::size_t passes_, targets_, skipped_, decisions_, shared_, keyedPasses_;
    bool committed_ = false;
};

}  // namespace clerestory
