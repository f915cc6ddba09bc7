// What each client holds of a process's bounded pools: one account that every pool consults and
// /metrics shows. Thread-safe. The queue of frames has rules of its own, which also take a place
// from a client (server/queue/fair_queue.h), and reports its use in the same form.
//
//     Holdings holdings({{Pool::streams, {.most = 32}}});
//     auto held = holdings.take(Pool::streams, call.client, 1);
//     if (!held) throw RequestError(streamsFull());
//
// A client may hold at most as much as is free then, so that a client alone can hold half of a
// pool, and others always find room: the second one a quarter, and so on. A client that holds
// nothing gets its first piece as long as there is room at all.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace clerestory {

enum class Pool : std::uint8_t {
    connections,    // that are open
    requestBytes,   // of large bodies that are received or handled
    responseBytes,  // of large answers and streams that wait for their readers
    smallResponseBytes,
    streams,  // live streams and sequences
    views,    // live views
    waits,    // for light or an uploaded scene; each occupies a thread of the front
    jobs      // that wait or run
};
inline constexpr std::size_t kPools = 8;
std::string_view nameOf(Pool pool);

class Holdings {
public:
    struct Limit {
        std::size_t most = 0;  // of all clients together
        // A first piece may exceed the limit if the pool is not full: for sizes that are known too
        // late to refuse.
        bool firstMayExceed = false;
    };
    // Pools that are not named have no limit.
    explicit Holdings(const std::map<Pool, Limit>& limits);
    Holdings(const Holdings&) = delete;
    Holdings& operator=(const Holdings&) = delete;

    // A part of a pool that a client holds as long as this exists. The account outlives it.
    class Held {
    public:
        Held(Held&& other) noexcept;
        Held& operator=(Held&& other) noexcept;
        ~Held();
        void resize(std::size_t amount);  // does not check the limit
        std::size_t amount() const { return amount_; }
        Pool pool() const { return pool_; }
        const std::string& client() const { return client_; }

    private:
        friend class Holdings;
        Held(Holdings& owner, Pool pool, std::string client, std::size_t amount)
            : owner_(&owner), pool_(pool), client_(std::move(client)), amount_(amount) {}
        Holdings* owner_;
        Pool pool_;
        std::string client_;
        std::size_t amount_;
    };

    // Empty if that is more than the client's share. Amount 0 is always accepted.
    std::optional<Held> take(Pool pool, const std::string& client, std::size_t amount);
    // Whether take() would accept it now.
    bool allows(Pool pool, const std::string& client, std::size_t amount) const;

    struct Usage {
        std::size_t total = 0;
        std::size_t clients = 0;   // that hold something
        std::size_t greatest = 0;  // that one client holds
        std::string greatestClient;
    };
    Usage usage(Pool pool) const;
    std::size_t of(Pool pool, const std::string& client) const;

private:
    struct Account {
        Limit limit;
        std::size_t total = 0;
        std::map<std::string, std::size_t> clients;
    };
    Account& account(Pool pool) { return accounts_[static_cast<std::size_t>(pool)]; }
    const Account& account(Pool pool) const { return accounts_[static_cast<std::size_t>(pool)]; }
    static bool fits(const Account& account, const std::string& client, std::size_t amount);
    void change(Pool pool, const std::string& client, std::size_t from, std::size_t to);

    mutable std::mutex mutex_;
    std::array<Account, kPools> accounts_;
};

}  // namespace clerestory
