#include "light/baker.h"

#include <malloc.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

namespace clerestory::light {
namespace {

// Samples that a thread takes at once: a millisecond or two.
constexpr std::uint32_t kSamplesAtOnce = 16;
// A thread that rests looks again after this time even if it is not woken.
constexpr std::chrono::milliseconds kRest{20};

// The threads rest while frames are drawn, so that this concerns other processes. With the lowest
// priority, 19, the light of a small scene was not complete after 15 minutes at a load of 7 to 10
// on two processors.
constexpr int kNice = 10;

// Where the system refuses, the threads have the priority of the others.
void lowerPriority() {
    [[maybe_unused]] const int result =
        setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), kNice);
}

}  // namespace

struct Baker::Shared {
    explicit Shared(const BakerOptions& given) : options(given) {}

    struct Entry {
        std::uint64_t key = 0;
        Make make;
        std::shared_ptr<Bake> bake;
        std::shared_ptr<const SurfaceLight> light;
        bool complete = false;
        std::string failure;

        bool finished() const { return complete || !failure.empty(); }
    };
    using Entries = std::list<Entry>;
    using Abandoned = std::function<bool()>;

    Entries::iterator find(std::uint64_t key) {
        return std::find_if(entries.begin(), entries.end(),
                            [&](const Entry& entry) { return entry.key == key; });
    }
    // Takes the lock. An entry may be dropped while a thread rests.
    bool isKnown(std::uint64_t key) {
        const std::lock_guard lock(mutex);
        return find(key) != entries.end();
    }
    // The entry begun or requested last that is not finished.
    Entries::iterator next() {
        return std::find_if(entries.begin(), entries.end(),
                            [](const Entry& entry) { return !entry.finished(); });
    }
    bool add(Entry entry);
    void dropBeyond(std::size_t allowed, bool finished);
    void startThreads();
    void coordinate();
    void help();
    bool restOrStop(const Abandoned& abandoned = {});
    void workOn(Bake& bake, const Abandoned& abandoned = {});
    void takePart(std::unique_lock<std::mutex>& lock, const Abandoned& abandoned = {});
    void runRound(std::uint64_t key, const std::shared_ptr<Bake>& bake);

    const BakerOptions options;
    std::mutex mutex;
    std::condition_variable changed;
    Entries entries;  // last used first
    bool stopping = false;
    std::atomic<int> resting{0};
    std::vector<std::thread> threads;

    // The round in progress.
    std::shared_ptr<Bake> current;
    std::uint64_t currentKey = 0;
    std::atomic<std::uint32_t> nextSample{0};
    std::uint32_t working = 0;  // helpers in it
    std::uint64_t roundNumber = 0;
    std::atomic<bool> cancelled{false};
};

// Returns false if the round is cancelled, or abandoned by this thread.
bool Baker::Shared::restOrStop(const Abandoned& abandoned) {
    const auto ends = [&] { return cancelled.load() || (abandoned && abandoned()); };
    while (resting.load() > 0) {
        if (ends()) return false;
        std::unique_lock lock(mutex);
        changed.wait_for(lock, kRest);
        if (stopping) return false;
    }
    return !ends();
}

void Baker::Shared::workOn(Bake& bake, const Abandoned& abandoned) {
    const std::uint32_t count = bake.samples();
    while (restOrStop(abandoned)) {
        const std::uint32_t first = nextSample.fetch_add(kSamplesAtOnce);
        if (first >= count) return;
        bake.work(first, std::min(first + kSamplesAtOnce, count));
    }
}

void Baker::Shared::help() {
    if (options.background) lowerPriority();
    std::uint64_t seen = 0;
    std::unique_lock lock(mutex);
    for (;;) {
        changed.wait(lock, [&] { return stopping || (current && roundNumber != seen); });
        if (stopping) return;
        seen = roundNumber;
        takePart(lock);
    }
}

// With the lock held and a round in progress: takes samples of it until none is left.
void Baker::Shared::takePart(std::unique_lock<std::mutex>& lock, const Abandoned& abandoned) {
    const std::shared_ptr<Bake> bake = current;
    ++working;
    lock.unlock();
    workOn(*bake, abandoned);
    lock.lock();
    --working;
    changed.notify_all();
}

void Baker::Shared::runRound(std::uint64_t key, const std::shared_ptr<Bake>& bake) {
    {
        const std::lock_guard lock(mutex);
        current = bake;
        currentKey = key;
        nextSample = 0;
        ++roundNumber;
    }
    changed.notify_all();
    workOn(*bake);
    std::unique_lock lock(mutex);
    current.reset();
    changed.wait(lock, [&] { return working == 0; });
}

void Baker::Shared::coordinate() {
    if (options.background) lowerPriority();
    std::unique_lock lock(mutex);
    while (!stopping) {
        const auto entry = next();
        if (entry == entries.end()) {
            changed.wait(lock);
            continue;
        }
        const std::uint64_t key = entry->key;
        std::shared_ptr<Bake> bake = entry->bake;
        const auto make = entry->make;
        cancelled = false;
        lock.unlock();
        std::string failure;
        std::shared_ptr<const SurfaceLight> light;
        bool complete = false;
        try {
            if (!bake && restOrStop() && isKnown(key)) bake = make();
            if (bake && bake->samples() > 0) runRound(key, bake);
            if (!cancelled && bake) {
                bake->endRound();
                complete = bake->complete() || bake->samples() == 0;
                light = std::make_shared<const SurfaceLight>(bake->light());
                if (complete && options.whenComplete) options.whenComplete(*light);
            }
        } catch (const std::exception& error) {
            failure = error.what();
            if (options.whenFailed) options.whenFailed(failure);
        }
        lock.lock();
        const auto found = find(key);
        if (found == entries.end() || cancelled) continue;
        found->bake = complete ? nullptr : bake;
        if (complete) found->make = nullptr;
        if (light) found->light = std::move(light);
        found->complete = complete;
        found->failure = std::move(failure);
        if (found->finished()) {
            entries.splice(entries.begin(), entries, found);
            dropBeyond(options.kept, true);
        }
        changed.notify_all();
        if (!complete) continue;
        lock.unlock();
        bake.reset();
        malloc_trim(0);  // a computation takes several times the memory of its result
        lock.lock();
    }
}

void Baker::Shared::startThreads() {
    const std::uint32_t count =
        options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    threads.emplace_back([this] { coordinate(); });
    for (std::uint32_t i = 1; i < count; ++i) threads.emplace_back([this] { help(); });
}

Baker::Baker(const BakerOptions& options) : shared_(std::make_unique<Shared>(options)) {}

Baker::~Baker() {
    {
        const std::lock_guard lock(shared_->mutex);
        shared_->stopping = true;
        shared_->cancelled = true;
    }
    shared_->changed.notify_all();
    for (std::thread& thread : shared_->threads) thread.join();
}

// With the lock held. Returns false if the key is known.
bool Baker::Shared::add(Entry entry) {
    if (find(entry.key) != entries.end()) return false;
    entries.push_front(std::move(entry));
    dropBeyond(options.kept, true);
    dropBeyond(options.waiting, false);
    return true;
}

// Drops the least recently used lights of those that are finished, or that are not.
void Baker::Shared::dropBeyond(std::size_t allowed, bool finished) {
    std::size_t count = 0;
    for (auto entry = entries.begin(); entry != entries.end();) {
        if (entry->finished() != finished || ++count <= allowed) {
            ++entry;
            continue;
        }
        if (current && current == entry->bake) cancelled = true;
        entry = entries.erase(entry);
    }
}

void Baker::begin(std::uint64_t key, Make make) {
    Shared& s = *shared_;
    const std::lock_guard lock(s.mutex);
    if (!s.add({.key = key, .make = std::move(make)})) return;
    if (s.threads.empty()) s.startThreads();
    s.changed.notify_all();
}

void Baker::keep(std::shared_ptr<const SurfaceLight> light) {
    Shared& s = *shared_;
    const std::lock_guard lock(s.mutex);
    const std::uint64_t key = light->key;
    s.add({.key = key, .light = std::move(light), .complete = true});
}

std::shared_ptr<const SurfaceLight> Baker::latest(std::uint64_t key) {
    Shared& s = *shared_;
    const std::lock_guard lock(s.mutex);
    const auto found = s.find(key);
    if (found == s.entries.end()) return nullptr;
    s.entries.splice(s.entries.begin(), s.entries, found);
    return found->light;
}

Baker::State Baker::state(std::uint64_t key) const {
    Shared& s = *shared_;
    const std::lock_guard lock(s.mutex);
    const auto found = s.find(key);
    if (found == s.entries.end()) return {};
    return {.known = true,
            .complete = found->complete,
            .share = found->light ? found->light->share : 0.0,
            .failure = found->failure};
}

Baker::State Baker::wait(std::uint64_t key, const std::function<bool()>& abandoned) {
    Shared& s = *shared_;
    std::uint64_t seen = 0;  // the last round that this thread took part in
    State now = state(key);
    while (now.known && !now.complete && now.failure.empty() && !(abandoned && abandoned())) {
        {
            std::unique_lock lock(s.mutex);
            if (s.current && s.currentKey == key && s.roundNumber != seen) {
                seen = s.roundNumber;
                s.takePart(lock, abandoned);
            } else {
                s.changed.wait_for(lock, kRest);
            }
        }
        now = state(key);
    }
    return now;
}

void Baker::forget(const Scene& scene) {
    Shared& s = *shared_;
    const std::lock_guard lock(s.mutex);
    std::erase_if(s.entries, [&](const Shared::Entry& entry) {
        return entry.light && entry.light->scene.get() == &scene;
    });
}

Baker::Rest::Rest(Baker& baker) : baker_(baker) {
    ++baker_.shared_->resting;
}

Baker::Rest::~Rest() {
    if (--baker_.shared_->resting == 0) baker_.shared_->changed.notify_all();
}

}  // namespace clerestory::light
