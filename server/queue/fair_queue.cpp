#include "server/queue/fair_queue.h"

#include <algorithm>

namespace clerestory {
namespace {

constexpr std::size_t kKindsKept = 1024;
constexpr std::size_t kLinesKept = 256;
constexpr double kNewest = 0.2;  // its share of the mean

double secondsIn(Clock::duration time) {
    return std::chrono::duration<double>(time).count();
}

}  // namespace

double CostBook::predicted(std::uint64_t kind) const {
    const auto found = costs_.find(kind);
    return found == costs_.end() ? mean_ : found->second.seconds;
}

void CostBook::learn(std::uint64_t kind, double seconds) {
    mean_ += kNewest * (seconds - mean_);
    if (costs_.size() >= kKindsKept && costs_.count(kind) == 0) costs_.clear();
    const auto [found, isNew] = costs_.try_emplace(kind);
    Cost& cost = found->second;
    cost.seconds =
        isNew || !cost.warm ? seconds : cost.seconds + kNewest * (seconds - cost.seconds);
    cost.warm = !isNew;
}

double FairQueue::heldBy(const std::string& client) const {
    const auto found = lines_.find(client);
    return found == lines_.end() ? 0.0 : found->second.held;
}

FairQueue::Lines::const_iterator FairQueue::greediest() const {
    return std::max_element(lines_.begin(), lines_.end(), [](const auto& a, const auto& b) {
        return a.second.held < b.second.held;
    });
}

bool FairQueue::hasRoom() const {
    return tickets_.empty() ||
           (tickets_.size() < limits_.count && waitingSeconds_ < limits_.seconds);
}

bool FairQueue::refuses(const std::string& client) const {
    return !hasRoom() && greediest()->second.held <= heldBy(client);
}

double FairQueue::remaining(Clock::time_point now) const {
    if (!running_) return 0.0;
    return std::max(running_->seconds - secondsIn(now - began_), 0.0);
}

FairQueue::Entry FairQueue::enter(const Ticket& ticket, Clock::time_point now) {
    const double seconds = costs_.predicted(ticket.kind);
    // Before it come at least what runs and the client's own.
    const double wait = remaining(now) + heldBy(ticket.client);
    if (ticket.deadline <= now || wait > secondsIn(ticket.deadline - now)) return {};
    Entry entry;
    const auto fits = [&] {
        return tickets_.empty() ||
               (tickets_.size() < limits_.count && waitingSeconds_ + seconds <= limits_.seconds);
    };
    while (!fits()) {
        const auto greedy = greediest();
        if (greedy->second.held <= heldBy(ticket.client) + seconds) break;
        entry.pushedOut.push_back(greedy->second.ids.back());
        take(entry.pushedOut.back());
    }
    if (!fits()) return entry;
    const Id id = nextId_++;
    Line& line = lines_[ticket.client];
    if (line.ids.empty()) line.had = std::max(line.had, had_);
    line.ids.push_back(id);
    try {
        tickets_.emplace(id, Waiting{ticket, seconds});
    } catch (...) {  // memory: as if it had never come
        line.ids.pop_back();
        throw;
    }
    line.held += seconds;
    waitingSeconds_ += seconds;
    entry.id = id;
    return entry;
}

FairQueue::Waiting FairQueue::take(Id id) {
    const auto found = tickets_.find(id);
    Waiting waiting = std::move(found->second);
    tickets_.erase(found);
    Line& line = lines_[waiting.ticket.client];
    line.ids.erase(std::find(line.ids.begin(), line.ids.end(), id));
    line.held = line.ids.empty() ? 0.0 : line.held - waiting.seconds;
    waitingSeconds_ = tickets_.empty() ? 0.0 : waitingSeconds_ - waiting.seconds;
    return waiting;
}

bool FairQueue::leave(Id id) {
    if (tickets_.count(id) == 0) return false;
    take(id);
    return true;
}

FairQueue::Turn FairQueue::next(Clock::time_point now) {
    Turn turn;
    while (!tickets_.empty()) {
        Lines::iterator first = lines_.end();
        for (auto line = lines_.begin(); line != lines_.end(); ++line) {
            if (line->second.ids.empty()) continue;
            if (first == lines_.end() || line->second.had < first->second.had) first = line;
        }
        const Id id = first->second.ids.front();
        Waiting waiting = take(id);
        if (waiting.ticket.deadline <= now) {
            turn.late.push_back(id);
            continue;
        }
        had_ = first->second.had;
        first->second.had += waiting.seconds;
        running_ = std::move(waiting);
        began_ = now;
        turn.id = id;
        break;
    }
    forgetQuietLines();
    return turn;
}

void FairQueue::finished(Clock::time_point now) {
    const double seconds = secondsIn(now - began_);
    costs_.learn(running_->ticket.kind, seconds);
    lines_[running_->ticket.client].had += seconds - running_->seconds;
    running_.reset();
}

void FairQueue::forgetQuietLines() {
    if (lines_.size() <= kLinesKept) return;
    std::erase_if(lines_, [&](const auto& line) { return line.second.ids.empty(); });
}

}  // namespace clerestory
