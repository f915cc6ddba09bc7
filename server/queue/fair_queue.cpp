#include "server/queue/fair_queue.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clerestory {
namespace {

constexpr std::size_t kMaxKinds = 1024;
constexpr std::size_t kMaxIdleClients = 256;
// A client that has held one entry at a time for so long is not overtaken repeatedly.
constexpr std::chrono::seconds kModerateTime{1};
// How far a client may be behind the others for what it used before: seconds.
constexpr double kMaxDebt = 10.0;
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

const FairQueue::ClientQueue* FairQueue::clientNamed(const std::string& name) const {
    const auto found = clients_.find(name);
    return found == clients_.end() ? nullptr : &found->second;
}

double FairQueue::share(std::size_t count, double seconds) const {
    const double byCount = static_cast<double>(count) / static_cast<double>(limits_.count);
    return std::max(byCount, seconds / (limits_.seconds * servers()));
}

FairQueue::ClientQueues::const_iterator FairQueue::heaviestClient() const {
    auto heaviest = clients_.end();
    double largest = 0.0;
    for (auto client = clients_.begin(); client != clients_.end(); ++client) {
        const ClientQueue& queue = client->second;
        if (queue.ids.size() < 2) continue;
        const double own = share(queue.ids.size(), queue.waitingSeconds);
        if (own <= largest) continue;
        largest = own;
        heaviest = client;
    }
    return heaviest;
}

bool FairQueue::hasRoom() const {
    return tickets_.empty() ||
           (tickets_.size() < limits_.count && waitingSeconds() < limits_.seconds);
}

bool FairQueue::fits(const ClientQueue* client, double seconds) const {
    if (tickets_.size() >= limits_.count) return tickets_.empty();
    if (!client || client->ids.empty()) return true;
    return waitingSeconds_ + seconds <= limits_.seconds * servers();
}

bool FairQueue::refuses(const std::string& client) const {
    const ClientQueue* own = clientNamed(client);
    const std::size_t count = own ? own->ids.size() : 0;
    const bool full =
        tickets_.size() >= limits_.count || (count > 0 && waitingSeconds() >= limits_.seconds);
    if (!full || tickets_.empty()) return false;
    const auto heaviest = heaviestClient();
    if (heaviest == clients_.end()) return true;
    const ClientQueue& other = heaviest->second;
    return count > 0 &&
           share(other.ids.size(), other.waitingSeconds) <= share(count + 1, own->waitingSeconds);
}

// Of all running work.
double FairQueue::remaining(Clock::time_point now) const {
    double seconds = 0.0;
    for (const auto& [id, running] : running_) {
        seconds += std::max(running.work.seconds - secondsIn(now - running.began), 0.0);
    }
    return seconds;
}

// Of the clients that have one waiting entry.
double FairQueue::onlyEntriesSeconds() const {
    double seconds = 0.0;
    for (const auto& [name, client] : clients_) {
        if (client.ids.size() == 1) seconds += client.waitingSeconds;
    }
    return seconds;
}

FairQueue::Added FairQueue::add(const Ticket& ticket, Clock::time_point now) {
    const double seconds = costs_.predict(ticket.kind);
    const ClientQueue* own = clientNamed(ticket.client);
    if (own && own->ids.size() + own->running > 0) clients_[ticket.client].lastHeldTwo = now;
    const double ownSeconds = own ? own->waitingSeconds : 0.0;
    const std::size_t ownCount = own ? own->ids.size() : 0;
    // At least the running work and the waiting work of the same client come first; before the
    // first entry of a client also the only entries of others.
    const double before = ownCount > 0 ? ownSeconds : onlyEntriesSeconds();
    const double wait = (remaining(now) + before) / servers();
    if (ticket.deadline <= now || wait > secondsIn(ticket.deadline - now)) return {};
    Added added;
    while (!fits(own, seconds)) {
        const auto heaviest = heaviestClient();
        if (heaviest == clients_.end()) break;
        const ClientQueue& other = heaviest->second;
        const bool isHeavier = ownCount == 0 || share(other.ids.size(), other.waitingSeconds) >
                                                    share(ownCount + 1, ownSeconds + seconds);
        if (&other == own || !isHeavier) break;
        added.evicted.push_back(other.ids.back());
        take(added.evicted.back());
    }
    if (!fits(own, seconds)) return added;
    const Id id = nextId_++;
    ClientQueue& client = clients_[ticket.client];
    client.ids.push_back(id);
    try {
        tickets_.emplace(id, Waiting{ticket, seconds});
    } catch (...) {  // out of memory: undo
        client.ids.pop_back();
        throw;
    }
    if (client.ids.size() == 1) {
        client.passed = 0;
        client.usedSeconds = std::clamp(client.usedSeconds, usedSeconds_, usedSeconds_ + kMaxDebt);
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

// Whether its only entry has waited for one entry of another client on each server, besides those
// that were running when it was added.
bool FairQueue::isUrgent(const ClientQueue& client, Clock::time_point now) const {
    const bool heldOne =
        client.lastHeldTwo == Clock::time_point::min() || now - client.lastHeldTwo >= kModerateTime;
    return heldOne && client.passed >= limits_.servers;
}

bool FairQueue::isBefore(const ClientQueue& a, const ClientQueue& b, Clock::time_point now) const {
    const bool isUrgentA = isUrgent(a, now), isUrgentB = isUrgent(b, now);
    if (isUrgentA != isUrgentB) return isUrgentA;
    if (!isUrgentA && a.usedSeconds != b.usedSeconds) return a.usedSeconds < b.usedSeconds;
    return a.ids.front() < b.ids.front();
}

void FairQueue::countPassed(const std::string& started) {
    for (auto& [name, client] : clients_) {
        if (name == started) {
            client.passed = 0;
        } else if (!client.ids.empty()) {
            ++client.passed;
        }
    }
}

FairQueue::Next FairQueue::next(Clock::time_point now, const std::function<bool(Id)>& mayStart) {
    Next next;
    while (!tickets_.empty()) {
        ClientQueues::iterator first = clients_.end();
        Id id = 0;
        double least = std::numeric_limits<double>::max();
        for (auto client = clients_.begin(); client != clients_.end(); ++client) {
            const std::deque<Id>& ids = client->second.ids;
            if (ids.empty()) continue;
            least = std::min(least, client->second.usedSeconds);
            if (first != clients_.end() && !isBefore(client->second, first->second, now)) continue;
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
        usedSeconds_ = std::max(usedSeconds_, least);
        countPassed(first->first);
        first->second.usedSeconds += waiting.seconds;
        ++first->second.running;
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
    ClientQueue& client = clients_.at(running.work.ticket.client);
    client.usedSeconds += seconds - running.work.seconds;
    --client.running;
}

QueueUsage FairQueue::usage() const {
    QueueUsage usage;
    const auto add = [](Holdings::Usage& to, const std::string& client, std::size_t amount) {
        to.total += amount;
        ++to.clients;
        if (amount <= to.greatest) return;
        to.greatest = amount;
        to.greatestClient = client;
    };
    for (const auto& [name, client] : clients_) {
        if (client.ids.empty()) continue;
        add(usage.entries, name, client.ids.size());
        add(usage.milliseconds, name,
            static_cast<std::size_t>(std::lround(1e3 * client.waitingSeconds)));
    }
    return usage;
}

int FairQueue::retryAfterSeconds() const {
    return static_cast<int>(std::clamp(std::ceil(0.5 * waitingSeconds()), 1.0, 60.0));
}

void FairQueue::removeIdleClients() {
    if (clients_.size() <= kMaxIdleClients) return;
    std::erase_if(clients_, [&](const auto& client) {
        return client.second.ids.empty() && client.second.running == 0;
    });
}

}  // namespace clerestory
