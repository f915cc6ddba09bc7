#include "server/base/holdings.h"

#include <algorithm>
#include <limits>

namespace clerestory {

std::string_view nameOf(Pool pool) {
    constexpr std::array<std::string_view, kPools> kNames = {
        "connections", "requestBytes", "responseBytes", "smallResponseBytes",
        "streams",     "views",        "waits",         "jobs"};
    return kNames.at(static_cast<std::size_t>(pool));
}

Holdings::Holdings(const std::map<Pool, Limit>& limits) {
    for (Account& each : accounts_) each.limit.most = std::numeric_limits<std::size_t>::max();
    for (const auto& [pool, limit] : limits) account(pool).limit = limit;
}

Holdings::Held::Held(Held&& other) noexcept
    : owner_(std::exchange(other.owner_, nullptr)),
      pool_(other.pool_),
      client_(std::move(other.client_)),
      amount_(other.amount_) {}

Holdings::Held& Holdings::Held::operator=(Held&& other) noexcept {
    std::swap(owner_, other.owner_);
    std::swap(pool_, other.pool_);
    std::swap(client_, other.client_);
    std::swap(amount_, other.amount_);
    return *this;
}

Holdings::Held::~Held() {
    if (owner_) owner_->change(pool_, client_, amount_, 0);
}

void Holdings::Held::resize(std::size_t amount) {
    if (amount == amount_) return;
    owner_->change(pool_, client_, amount_, amount);
    amount_ = amount;
}

void Holdings::change(Pool pool, const std::string& client, std::size_t from, std::size_t to) {
    if (from == to) return;
    const std::lock_guard lock(mutex_);
    Account& all = account(pool);
    // Only growth allocates, before anything is changed: destructors release.
    const auto own = to > from ? all.clients.try_emplace(client).first : all.clients.find(client);
    own->second += to - from;  // unsigned: may wrap on the way
    all.total += to - from;
    if (own->second == 0) all.clients.erase(own);
}

bool Holdings::fits(const Account& account, const std::string& client, std::size_t amount) {
    if (amount == 0) return true;
    const std::size_t most = account.limit.most;
    const std::size_t room = most - std::min(most, account.total);
    const auto found = account.clients.find(client);
    const std::size_t own = found == account.clients.end() ? 0 : found->second;
    if (own == 0) return account.limit.firstMayExceed ? room > 0 : amount <= room;
    // At most what is free then; a share that is counted in ones is rounded up.
    return amount <= room && own + amount <= room - amount + 1;
}

bool Holdings::allows(Pool pool, const std::string& client, std::size_t amount) const {
    const std::lock_guard lock(mutex_);
    return fits(account(pool), client, amount);
}

std::optional<Holdings::Held> Holdings::take(Pool pool, const std::string& client,
                                             std::size_t amount) {
    const std::lock_guard lock(mutex_);
    Account& all = account(pool);
    if (!fits(all, client, amount)) return std::nullopt;
    std::string name = client;  // whatever allocates comes before the change
    if (amount > 0) all.clients[client] += amount;
    all.total += amount;
    return Held(*this, pool, std::move(name), amount);
}

Holdings::Usage Holdings::usage(Pool pool) const {
    const std::lock_guard lock(mutex_);
    const Account& all = account(pool);
    Usage usage{.total = all.total, .clients = all.clients.size(), .greatestClient = {}};
    for (const auto& [client, amount] : all.clients) {
        if (amount <= usage.greatest) continue;
        usage.greatest = amount;
        usage.greatestClient = client;
    }
    return usage;
}

std::size_t Holdings::of(Pool pool, const std::string& client) const {
    const std::lock_guard lock(mutex_);
    const auto found = account(pool).clients.find(client);
    return found == account(pool).clients.end() ? 0 : found->second;
}

}  // namespace clerestory
