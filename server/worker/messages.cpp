#include "server/worker/messages.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace clerestory {
namespace {

constexpr std::array<const char*, 6> kHeaders = {"Content-Type",        "Accept", "If-None-Match",
                                                 "Clerestory-Deadline", "Prefer", "Sec-Fetch-Site"};

struct AnyVisitor {
    template <class T, class Kind>
    void operator()(const char*, T&, const Kind&, const char*) {}
};
// Structs with a field table (renderer/scene/fields.h).
template <class T>
concept HasFields = requires(T& value) {
    fields(value, AnyVisitor{});
};
template <class T>
concept Plain = std::is_trivially_copyable_v<T> && std::is_copy_assignable_v<T> && !HasFields<T>;

class Writer {
public:
    template <Plain T>
    void put(const T& value) {
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    void put(const std::string& value) {
        put(value.size());
        bytes_.append(value);
    }
    template <class T>
    void put(const std::optional<T>& value) {
        put(value.has_value());
        if (value) put(*value);
    }
    template <class... Ts>
    void put(const std::variant<Ts...>& value) {
        put(value.index());
        std::visit([this](const auto& held) { put(held); }, value);
    }
    template <class T>
    void put(const std::vector<T>& list) {
        put(list.size());
        for (const T& value : list) put(value);
    }
    template <class A, class B>
    void put(const std::pair<A, B>& value) {
        put(value.first);
        put(value.second);
    }
    template <HasFields T>
    void put(const T& value) {
        T copy = value;  // the tables visit values that can be changed
        fields(copy,
               [this](const char*, const auto& member, const auto&, const char*) { put(member); });
    }
    void put(const PlacedScenes& scenes) {
        put(scenes.id);
        put(scenes.parts);
    }
    void put(const FieldError& error) {
        put(error.pointer);
        put(error.detail);
        put(error.allowed);
    }
    void put(const Problem& problem) {
        put(problem.status);
        put(problem.code);
        for (const std::string* text :
             {&problem.title, &problem.detail, &problem.allow, &problem.reason}) {
            put(*text);
        }
        put(problem.errors);
        put(problem.retryAfterSeconds);
    }
    void put(const FrameCamera& camera) {
        put(camera.cameraToWorld);
        put(camera.clipFromView);
        put(camera.width);
        put(camera.height);
        put(camera.znear);
        put(camera.intrinsics);
        put(camera.lens);
    }
    void put(const JobEvent& event) {
        put(event.kind);
        put(event.id);
    }

    std::string take() { return std::move(bytes_); }

private:
    std::string bytes_;
};

class Reader {
public:
    explicit Reader(std::string_view bytes) : rest_(bytes) {}

    template <Plain T>
    void get(T& value) {
        std::memcpy(&value, part(sizeof value).data(), sizeof value);
    }
    void get(bool& value) { value = number<unsigned char>() != 0; }
    void get(std::string& value) { value = part(number<std::size_t>()); }
    template <class T>
    void get(std::optional<T>& value) {
        value.reset();
        if (number<bool>()) get(value.emplace());
    }
    template <class... Ts>
    void get(std::variant<Ts...>& value) {
        getAlternative<0>(value, number<std::size_t>());
    }
    // Each element takes bytes, so that a wrong size ends with them.
    template <class T>
    void get(std::vector<T>& list) {
        list.clear();
        for (std::size_t left = number<std::size_t>(); left > 0; --left) get(list.emplace_back());
    }
    template <class A, class B>
    void get(std::pair<A, B>& value) {
        get(value.first);
        get(value.second);
    }
    template <HasFields T>
    void get(T& value) {
        fields(value, [this](const char*, auto& member, const auto&, const char*) { get(member); });
    }
    void get(PlacedScenes& scenes) {
        get(scenes.id);
        get(scenes.parts);
    }
    void get(FieldError& error) {
        get(error.pointer);
        get(error.detail);
        get(error.allowed);
    }
    void get(Problem& problem) {
        get(problem.status);
        get(problem.code);
        for (std::string* text :
             {&problem.title, &problem.detail, &problem.allow, &problem.reason}) {
            get(*text);
        }
        get(problem.errors);
        get(problem.retryAfterSeconds);
    }
    void get(FrameCamera& camera) {
        get(camera.cameraToWorld);
        get(camera.clipFromView);
        get(camera.width);
        get(camera.height);
        get(camera.znear);
        get(camera.intrinsics);
        get(camera.lens);
    }
    void get(JobEvent& event) {
        get(event.kind);
        get(event.id);
    }
    void get(Clock::time_point& time) {
        time = Clock::time_point(Clock::duration(number<Clock::rep>()));
    }

    bool done() const { return rest_.empty(); }
    void end() const {
        if (!done()) throw std::runtime_error("a message is too long");
    }

private:
    template <class T>
    T number() {
        T value{};
        get(value);
        return value;
    }
    template <std::size_t index, class... Ts>
    void getAlternative(std::variant<Ts...>& value, std::size_t wanted) {
        if constexpr (index < sizeof...(Ts)) {
            if (wanted == index) return get(value.template emplace<index>());
            getAlternative<index + 1>(value, wanted);
        } else {
            throw std::runtime_error("a message has an unknown alternative");
        }
    }
    std::string_view part(std::size_t size) {
        if (size > rest_.size()) throw std::runtime_error("a message is too short");
        const std::string_view first = rest_.substr(0, size);
        rest_.remove_prefix(size);
        return first;
    }
    std::string_view rest_;
};

template <class... Parts>
std::string packedParts(const Parts&... parts) {
    Writer out;
    (out.put(parts), ...);
    return out.take();
}

template <class... Parts>
void unpackParts(std::string_view bytes, Parts&... parts) {
    Reader in(bytes);
    (in.get(parts), ...);
    in.end();
}

// The largest frame as float32 with its plan fits.
constexpr std::uint64_t kMaxBytes = 512ull << 20;

struct Head {
    MessageKind kind;
    std::uint32_t unused;
    std::uint64_t id, size;
};

}  // namespace

std::shared_ptr<CancellationToken> cancellationOf(const WorkerRequest& request) {
    if (const auto* call = std::get_if<Call>(&request)) return call->cancellation;
    if (const auto* order = std::get_if<FrameOrder>(&request)) return order->cancellation;
    return nullptr;
}

std::string packed(const Call& call) {
    const std::vector<std::pair<std::string, std::string>> query(call.query.begin(),
                                                                 call.query.end());
    std::vector<std::string> headers;
    for (const char* name : kHeaders) headers.push_back(call.header ? call.header(name) : "");
    return packedParts(call.method, call.path, query, call.body, call.requestId, call.client,
                       call.job, call.arrived, headers);
}

Call unpackedCall(std::string_view bytes) {
    Call call;
    std::vector<std::pair<std::string, std::string>> query;
    std::vector<std::string> headers;
    unpackParts(bytes, call.method, call.path, query, call.body, call.requestId, call.client,
                call.job, call.arrived, headers);
    if (headers.size() != kHeaders.size()) throw std::runtime_error("a message lacks headers");
    call.query.insert(query.begin(), query.end());
    call.header = [headers = std::move(headers)](const char* name) -> std::string {
        for (std::size_t i = 0; i < kHeaders.size(); ++i) {
            if (std::strcmp(kHeaders[i], name) == 0) return headers[i];
        }
        return {};
    };
    return call;
}

std::string packed(const FrameOrder& order) {
    return packedParts(order.request, order.withPlan, order.requestId, order.client, order.arrived,
                       order.endsInProgress, order.wholeLight);
}

FrameOrder unpackedFrameOrder(std::string_view bytes) {
    FrameOrder order;
    unpackParts(bytes, order.request, order.withPlan, order.requestId, order.client, order.arrived,
                order.endsInProgress, order.wholeLight);
    return order;
}

std::string packed(const Answer& answer) {
    return packedParts(answer.status, answer.type, answer.route, answer.problem, answer.job,
                       answer.sceneHash, answer.headers, answer.body);
}

Answer unpackedAnswer(std::string_view bytes) {
    Answer answer;
    unpackParts(bytes, answer.status, answer.type, answer.route, answer.problem, answer.job,
                answer.sceneHash, answer.headers, answer.body);
    return answer;
}

std::string packed(const EncodedFrame& frame) {
    return packedParts(frame.type, frame.bytes, frame.milliseconds, frame.lightShare, frame.camera,
                       frame.passMilliseconds, frame.plan);
}

EncodedFrame unpackedFrame(std::string_view bytes) {
    EncodedFrame frame;
    unpackParts(bytes, frame.type, frame.bytes, frame.milliseconds, frame.lightShare, frame.camera,
                frame.passMilliseconds, frame.plan);
    return frame;
}

std::string packed(const SceneReport& report) {
    return packedParts(report.state, report.isKnown, report.failure, report.reason,
                       report.description);
}

SceneReport unpackedSceneReport(std::string_view bytes) {
    SceneReport report;
    unpackParts(bytes, report.state, report.isKnown, report.failure, report.reason,
                report.description);
    return report;
}

std::string packed(const Problem& problem) {
    return packedParts(problem);
}

Problem unpackedProblem(std::string_view bytes) {
    Problem problem;
    unpackParts(bytes, problem);
    return problem;
}

std::string packed(const std::vector<std::string>& texts) {
    Writer out;
    for (const std::string& text : texts) out.put(text);
    return out.take();
}

std::vector<std::string> unpackedTexts(std::string_view bytes) {
    std::vector<std::string> texts;
    for (Reader in(bytes); !in.done();) in.get(texts.emplace_back());
    return texts;
}

std::string packed(const LoadedScenes& scenes) {
    return packedParts(scenes.defaultScene, scenes.renderer, scenes.scenes);
}

LoadedScenes unpackedScenes(std::string_view bytes) {
    LoadedScenes scenes;
    unpackParts(bytes, scenes.defaultScene, scenes.renderer, scenes.scenes);
    return scenes;
}

MessagePipe::~MessagePipe() {
    close(socket_);
}

bool MessagePipe::send(const Message& message) {
    const Head head{message.kind, 0, message.id, message.bytes.size()};
    const std::lock_guard lock(sending_);
    return writeAll(reinterpret_cast<const char*>(&head), sizeof head) &&
           writeAll(message.bytes.data(), message.bytes.size());
}

void MessagePipe::trySend(MessageKind kind, std::uint64_t id) {
    const std::unique_lock lock(sending_, std::try_to_lock);
    if (!lock) return;
    const Head head{kind, 0, id, 0};
    // So few bytes are sent whole or not at all.
    ::send(socket_, &head, sizeof head, MSG_NOSIGNAL | MSG_DONTWAIT);
}

std::optional<Message> MessagePipe::receive() {
    Head head{};
    if (!readAll(reinterpret_cast<char*>(&head), sizeof head)) return std::nullopt;
    if (head.kind > MessageKind::hangs || head.size > kMaxBytes) return std::nullopt;
    Message message{.kind = head.kind, .id = head.id, .bytes = std::string(head.size, '\0')};
    if (!readAll(message.bytes.data(), message.bytes.size())) return std::nullopt;
    return message;
}

void MessagePipe::shut() {
    shutdown(socket_, SHUT_RDWR);
}

bool MessagePipe::writeAll(const char* bytes, std::size_t size) {
    while (size > 0) {
        const ssize_t sent = ::send(socket_, bytes, size, MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) return false;
        bytes += sent;
        size -= static_cast<std::size_t>(sent);
    }
    return true;
}

bool MessagePipe::readAll(char* bytes, std::size_t size) {
    while (size > 0) {
        const ssize_t got = recv(socket_, bytes, size, 0);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        bytes += got;
        size -= static_cast<std::size_t>(got);
    }
    return true;
}

}  // namespace clerestory
