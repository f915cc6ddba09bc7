#include "server/api/frame_cache.h"

#include "scene/hash.h"
#include "server/api/frame_json.h"
#include "server/api/frames.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <span>
#include <utility>

namespace clerestory {
namespace {

// Of an entry in addition to its text: the lists, the table and the allocator.
constexpr std::size_t kEntryBytes = 1024;

// Different ways to write one request that are recognised without parsing.
constexpr std::size_t kMaxForms = 4;

std::uint64_t formOf(const Call& call, std::string_view body) {
    return hashOfBytes(std::as_bytes(std::span(body)), hashOf(call.method + ' ' + call.target));
}

// Whether a Cache-Control header has the directive.
bool hasDirective(std::string header, std::string_view wanted) {
    std::transform(header.begin(), header.end(), header.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (std::size_t begin = 0; begin < header.size();) {
        const std::size_t end = std::min(header.find(',', begin), header.size());
        std::size_t first = begin, last = end;
        while (first < last && (header[first] == ' ' || header[first] == '\t')) ++first;
        while (first < last && (header[last - 1] == ' ' || header[last - 1] == '\t')) --last;
        if (std::string_view(header).substr(first, last - first) == wanted) return true;
        begin = end + 1;
    }
    return false;
}

const std::uint64_t* contentHashIn(const LoadedScenes& loaded, const std::string& scene) {
    const auto found = std::find_if(loaded.scenes.begin(), loaded.scenes.end(),
                                    [&](const auto& one) { return one.first == scene; });
    return found == loaded.scenes.end() ? nullptr : &found->second;
}

std::size_t bytesOf(const Answer& answer) {
    std::size_t bytes = answer.content().size() + answer.type.size() + answer.route.size();
    for (const auto& [name, value] : answer.headers) bytes += name.size() + value.size();
    return bytes;
}

std::string headerOf(const Answer& answer, std::string_view wanted) {
    for (const auto& [name, value] : answer.headers) {
        if (name == wanted) return value;
    }
    return {};
}

}  // namespace

// The request of a frame whose answer may be stored. Errors of the request are left to the backend.
std::optional<FrameRequest> FrameCache::storableRequest(const Call& call) const {
    if (options_.maxBytes == 0 || stopping_ || call.path != "/v1/frames") return std::nullopt;
    if (call.method != "GET" && call.method != "POST") return std::nullopt;
    if (hasDirective(call.header("Cache-Control"), "no-store")) return std::nullopt;
    try {
        FrameCall frame = frameCallFrom(call, options_.signedLinks);
        deadlineIn(call);
        if (frame.explain != Explain::no || frame.request.accuracy.isBudget()) return std::nullopt;
        return std::move(frame.request);
    } catch (const RequestError&) {
        return std::nullopt;
    }
}

bool FrameCache::hasMapsOf(const FrameRequest& request) const {
    const std::vector<NamedMap> named = mapsNamedBy(request);
    return std::all_of(named.begin(), named.end(), [&](const NamedMap& map) {
        return !UploadStore::isId(map.name) ||
               (options_.uploads && options_.uploads->find(map.name));
    });
}

// Empty while the scene or an uploaded map is not there.
std::optional<FrameCache::Key> FrameCache::keyFor(const FrameRequest& given) const {
    if (!given.parts.empty()) return std::nullopt;  // entries belong to one scene
    if (!hasMapsOf(given)) return std::nullopt;
    const auto loaded = backend_.loadedScenes();
    if (!loaded) return std::nullopt;
    FrameRequest request = given;
    if (request.scene.empty()) request.scene = loaded->defaultScene;
    const std::uint64_t* hash = contentHashIn(*loaded, request.scene);
    if (!hash) return std::nullopt;
    return Key{.text = canonicalText(request) + '\n' + std::to_string(*hash) + '\n' +
                       std::to_string(loaded->renderer),
               .scene = request.scene,
               .contentHash = *hash};
}

Answer FrameCache::answer(const Call& call) {
    const auto request = storableRequest(call);
    if (request) {
        if (auto found = find(*request, call)) return *std::move(found);
    }
    if (options_.maxBytes > 0 && needsRenderQueue(call)) requireRoom(call);
    Answer answer = backend_.answer(call);
    if (request) store(*request, call, answer);
    return answer;
}

bool FrameCache::mayHold(const Call& call, std::string_view body) const {
    if (options_.maxBytes == 0) return false;
    const std::uint64_t form = formOf(call, body);
    const std::lock_guard lock(mutex_);
    return forms_.contains(form);
}

// While the queue is full, the connections' thread admits calls that the cache may answer; others
// are refused here.
void FrameCache::requireRoom(const Call& call) const {
    if (!call.header("If-None-Match").empty()) return;
    if (const auto problem = backend_.refusalFor(call.client)) throw RequestError(*problem);
}

std::optional<Answer> FrameCache::find(const FrameRequest& request, const Call& call) {
    const auto key = keyFor(request);
    std::shared_ptr<const Answer> stored;
    Clock::time_point drawn;
    {
        const std::lock_guard lock(mutex_);
        forgetUnloaded();
        const auto found = key ? byKey_.find(key->text) : byKey_.end();
        if (found == byKey_.end() || hasDirective(call.header("Cache-Control"), "no-cache")) {
            ++counters_.misses;
            return std::nullopt;
        }
        const std::string ifNoneMatch = call.header("If-None-Match");
        if (call.method == "GET" && !ifNoneMatch.empty() &&
            matchesEntityTag(ifNoneMatch, headerOf(*found->second->answer, "ETag"))) {
            return std::nullopt;
        }
        ++counters_.hits;
        list_.splice(list_.begin(), list_, found->second);
        addForm(list_.front(), formOf(call, call.body));
        stored = found->second->answer;
        drawn = found->second->drawn;
    }
    Answer answer = *stored;
    const auto age = std::chrono::floor<std::chrono::seconds>(Clock::now() - drawn);
    answer.headers.emplace_back("Age", std::to_string(age.count()));
    return answer;
}

void FrameCache::store(const FrameRequest& request, const Call& call, Answer& answer) {
    const bool complete = answer.status == 200 && !answer.problem && !answer.stream;
    if (!complete || headerOf(answer, "ETag").empty()) return;
    const std::string light = headerOf(answer, "Clerestory-Light");
    if (!light.empty() && light.find("share=1.00") == std::string::npos) return;  // will change
    const auto key = keyFor(request);
    if (!key || key->contentHash != answer.sceneHash) return;  // the scene has changed since
    const std::size_t bytes = bytesOf(answer) + key->text.size() + kEntryBytes;
    if (bytes > options_.maxBytes) return;
    answer.shared = std::make_shared<const std::string>(std::exchange(answer.body, {}));
    auto stored = std::make_shared<const Answer>(answer);
    const std::lock_guard lock(mutex_);
    forgetUnloaded();
    const auto known = known_.find(key->scene);
    if (known == known_.end() || known->second != key->contentHash) return;
    if (const auto same = byKey_.find(key->text); same != byKey_.end()) remove(same->second);
    while (counters_.bytes + bytes > options_.maxBytes) {
        remove(std::prev(list_.end()));
        ++counters_.evicted;
    }
    list_.push_front({.key = key->text,
                      .scene = key->scene,
                      .contentHash = key->contentHash,
                      .bytes = bytes,
                      .answer = std::move(stored),
                      .drawn = Clock::now()});
    counters_.bytes += bytes;
    byKey_.emplace(list_.front().key, list_.begin());
    addForm(list_.front(), formOf(call, call.body));
}

// With the lock held.
void FrameCache::addForm(Entry& entry, std::uint64_t form) {
    if (entry.forms.size() >= kMaxForms || !forms_.insert(form).second) return;
    entry.forms.push_back(form);
}

// With the lock held.
void FrameCache::remove(std::list<Entry>::iterator entry) {
    counters_.bytes -= entry->bytes;
    byKey_.erase(entry->key);
    for (const std::uint64_t form : entry->forms) forms_.erase(form);
    list_.erase(entry);
}

// With the lock held: removes the entries of scenes that are not loaded any more, or with another
// content.
void FrameCache::forgetUnloaded() {
    const auto loaded = backend_.loadedScenes();
    if (!loaded) return;
    std::map<std::string, std::uint64_t> now(loaded->scenes.begin(), loaded->scenes.end());
    const auto isLoaded = [&](const std::string& scene, std::uint64_t hash) {
        const auto found = now.find(scene);
        return found != now.end() && found->second == hash;
    };
    const bool allStay = std::all_of(known_.begin(), known_.end(), [&](const auto& one) {
        return isLoaded(one.first, one.second);
    });
    for (auto entry = list_.begin(); !allStay && entry != list_.end();) {
        const auto here = entry++;
        if (!isLoaded(here->scene, here->contentHash)) remove(here);
    }
    known_ = std::move(now);
}

FrameCacheCounters FrameCache::counters() {
    const std::lock_guard lock(mutex_);
    forgetUnloaded();
    FrameCacheCounters counters = counters_;
    counters.entries = list_.size();
    return counters;
}

}  // namespace clerestory
