// Answers repeated requests of /v1/frames from memory, in the process that clients reach: without a
// place in the queue, without the renderer. Thread-safe.
//
//     FrameCache cache(backend, {.maxBytes = 64 << 20});
//     Answer answer = cache.answer(call);  // of any call of the renderer
//
// The key is everything that the answer depends on: the request in its canonical form with every
// field, the content of its scene, the program, the driver and the environment maps. The plan
// follows from these, so it is not computed. Entries are found only while the renderer holds the
// scene with that content, and while the uploaded maps that the request names are stored; those of
// other scenes are removed.
//
// A hit has the bytes and headers of the drawn answer, so that Server-Timing and Clerestory-Passes
// are those of the drawing, and the header Age: whole seconds since then. Not stored are:
// - answers other than 200;
// - frames whose light of surfaces is not complete (Clerestory-Light);
// - frames with `explain`, which contain measured times;
// - frames of a budget, whose settings were chosen from measured times.
// A request with Cache-Control: no-cache is drawn again and replaces its entry; no-store also
// leaves the cache as it is. A GET whose If-None-Match names the frame is answered by the renderer
// with 304.
#pragma once

#include "server/api/backend.h"
#include "server/base/call.h"
#include "server/scenes/upload_store.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace clerestory {

// Of the present entries, and events since the start.
struct FrameCacheCounters {
    std::size_t bytes = 0, entries = 0;
    std::uint64_t hits = 0, misses = 0;  // of frames that may be stored
    std::uint64_t evicted = 0;           // to make room for others
};

class FrameCache {
public:
    struct Options {
        // Of all entries with their keys; beyond it the least recently used one is removed. Larger
        // answers are not stored. 0: no cache.
        std::size_t maxBytes = 0;
        bool signedLinks = false;              // as FrameRoutes::signedLinks
        const UploadStore* uploads = nullptr;  // null: not allowed
    };

    // The backend must outlive this.
    FrameCache(RenderBackend& backend, const Options& options)
        : backend_(backend), options_(options) {}

    // The stored answer, or that of the backend. Throws what the backend throws.
    Answer answer(const Call& call);

    // Whether a request with the same bytes was answered by a present entry. For the thread of the
    // connections, which refuses requests while the queue is full: it does not parse them.
    bool mayHold(const Call& call, std::string_view body) const;

    // Nothing is answered from memory any more.
    void stop() { stopping_ = true; }

    FrameCacheCounters counters();

private:
    struct Entry {
        std::string key, scene;
        std::uint64_t contentHash = 0;
        std::size_t bytes = 0;
        std::shared_ptr<const Answer> answer;
        Clock::time_point drawn;
        std::vector<std::uint64_t> forms;  // hashes of requests that it answered, as they were sent
    };
    // Identifies the answer to a request.
    struct Key {
        std::string text, scene;
        std::uint64_t contentHash = 0;
    };
    std::optional<FrameRequest> storableRequest(const Call& call) const;
    bool hasMapsOf(const FrameRequest& request) const;
    std::optional<Key> keyFor(const FrameRequest& request) const;
    void requireRoom(const Call& call) const;
    std::optional<Answer> find(const FrameRequest& request, const Call& call);
    // Moves the bytes to `shared` if it stores the answer.
    void store(const FrameRequest& request, const Call& call, Answer& answer);
    void forgetUnloaded();
    void addForm(Entry& entry, std::uint64_t form);
    void remove(std::list<Entry>::iterator entry);

    RenderBackend& backend_;
    const Options options_;
    std::atomic<bool> stopping_{false};

    mutable std::mutex mutex_;
    std::list<Entry> list_;  // the most recently used one first
    std::unordered_map<std::string_view, std::list<Entry>::iterator> byKey_;  // keys are in list_
    std::unordered_set<std::uint64_t> forms_;                                 // of all entries
    std::map<std::string, std::uint64_t> known_;  // scenes that were loaded at the last look
    FrameCacheCounters counters_;
};

}  // namespace clerestory
