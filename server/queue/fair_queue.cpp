#include "server/queue/fair_queue.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

constexpr std::size_t kMaxKinds = 1024;
constexpr std::size_t kMaxIdleClients = 256;
constexpr double kUpdateWeight = 0.2;  // of the latest time in the moving mean

double secondsIn(Clock::duration time) {
    return std::chrono::duration<double>(time).count();
}

}  // namespace

double CostPredictor::predict(std::uint64_t kind) const {
    const auto found = costs_.find(kind);
    return found == costs_.end() ? mean_ : found->second.seconds;
}

void CostPredictor::update(std::uint64_t kind, double seconds) {
    mean_ += kUpdateWeight * (seconds - mean_);
    if (costs_.size() >= kMaxKinds && costs_.count(kind) == 0) costs_.clear();
    const auto [found, isNew] = costs_.try_emplace(kind);
    Cost& cost = found->second;
    cost.seconds =
        isNew || !cost.warm ? seconds : cost.seconds + kUpdateWeight * (seconds - cost.seconds);
    cost.warm = !isNew;
}

double FairQueue::waitingSecondsOf(const std::string& client) const {
    const auto found = clients_.find(client);
    return found == clients_.end() ? 0.0 : found->second.waitingSeconds;
}

FairQueue::ClientQueues::const_iterator FairQueue::heaviestClient() const {
    return std::max_element(clients_.begin(), clients_.end(), [](const auto& a, const auto& b) {
        return a.second.waitingSeconds < b.second.waitingSeconds;
    });
}

bool FairQueue::hasRoom() const {
    return tickets_.empty() ||
           (tickets_.size() < limits_.count && waitingSeconds() < limits_.seconds);
}

bool FairQueue::refuses(const std::string& client) const {
    return !hasRoom() && heaviestClient()->second.waitingSeconds <= waitingSecondsOf(client);
}

// Of all running work.
double FairQueue::remaining(Clock::time_point now) const {
    double seconds = 0.0;
    for (const auto& [id, running] : running_) {
        seconds += std::max(running.work.seconds - secondsIn(now - running.began), 0.0);
    }
    return seconds;
}

FairQueue::Added FairQueue::add(const Ticket& ticket, Clock::time_point now) {
    const double seconds = costs_.predict(ticket.kind);
    // At least the running work and the waiting work of the same client come first.
    const double wait = (remaining(now) + waitingSecondsOf(ticket.client)) / servers();
    if (ticket.deadline <= now || wait > secondsIn(ticket.deadline - now)) return {};
    Added added;
    const auto fits = [&] {
        return tickets_.empty() || (tickets_.size() < limits_.count &&
                                    waitingSeconds_ + seconds <= limits_.seconds * servers());
    };
    while (!fits()) {
        const auto heaviest = heaviestClient();
        if (heaviest->second.waitingSeconds <= waitingSecondsOf(ticket.client) + seconds) break;
        added.evicted.push_back(heaviest->second.ids.back());
        take(added.evicted.back());
    }
    if (!fits()) return added;
    const Id id = nextId_++;
    ClientQueue& client = clients_[ticket.client];
    if (client.ids.empty()) client.usedSeconds = std::max(client.usedSeconds, usedSeconds_);
    client.ids.push_back(id);
    try {
        tickets_.emplace(id, Waiting{ticket, seconds});
    } catch (...) {  // out of memory: undo
        client.ids.pop_back();
        throw;
    }
    client.waitingSeconds += seconds;
    waitingSeconds_ += seconds;
    added.id = id;
    return added;
}

FairQueue::Waiting FairQueue::take(Id id) {
    const auto found = tickets_.find(id);
    Waiting waiting = std::move(found->second);
    tickets_.erase(found);
    ClientQueue& client = clients_[waiting.ticket.client];
    client.ids.erase(std::find(client.ids.begin(), client.ids.end(), id));
    client.waitingSeconds = client.ids.empty() ? 0.0 : client.waitingSeconds - waiting.seconds;
    waitingSeconds_ = tickets_.empty() ? 0.0 : waitingSeconds_ - waiting.seconds;
    return waiting;
}

bool FairQueue::remove(Id id) {
    if (tickets_.count(id) == 0) return false;
    take(id);
    return true;
}

FairQueue::Next FairQueue::next(Clock::time_point now, const std::function<bool(Id)>& mayStart) {
    Next next;
    while (!tickets_.empty()) {
        ClientQueues::iterator first = clients_.end();
        Id id = 0;
        for (auto client = clients_.begin(); client != clients_.end(); ++client) {
            const std::deque<Id>& ids = client->second.ids;
            if (first != clients_.end() &&
                client->second.usedSeconds >= first->second.usedSeconds) {
                continue;
            }
            const auto found =
                mayStart ? std::find_if(ids.begin(), ids.end(), std::cref(mayStart)) : ids.begin();
            if (found == ids.end()) continue;
            first = client;
            id = *found;
        }
        if (first == clients_.end()) break;
        Waiting waiting = take(id);
        if (waiting.ticket.deadline <= now) {
            next.expired.push_back(id);
            continue;
        }
        usedSeconds_ = first->second.usedSeconds;
        first->second.usedSeconds += waiting.seconds;
        running_.emplace(id, Running{std::move(waiting), now});
        next.id = id;
        break;
    }
    removeIdleClients();
    return next;
}

void FairQueue::finished(Id id, Clock::time_point now, bool complete) {
    const auto found = running_.find(id);
    const Running running = std::move(found->second);
    running_.erase(found);
    const double seconds = secondsIn(now - running.began);
    if (complete) costs_.update(running.work.ticket.kind, seconds);
    clients_[running.work.ticket.client].usedSeconds += seconds - running.work.seconds;
}

int FairQueue::retryAfterSeconds() const {
    return static_cast<int>(std::clamp(std::ceil(0.5 * waitingSeconds()), 1.0, 60.0));
}

void FairQueue::removeIdleClients() {
    if (clients_.size() <= kMaxIdleClients) return;
    std::erase_if(clients_, [&](const auto& client) { return client.second.ids.empty(); });
}

}  // namespace clerestory
