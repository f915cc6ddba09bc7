#include "server/worker/call_wire.h"

#include <array>
#include <cstring>
#include <stdexcept>

namespace clerestory {
namespace {

constexpr std::array<const char*, 4> kHeaders = {"Content-Type", "Accept", "If-None-Match",
                                                 "Clerestory-Deadline"};

class Writer {
public:
    void number(std::int64_t value) {
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    void text(std::string_view value) {
        number(static_cast<std::int64_t>(value.size()));
        bytes_.append(value);
    }
    template <class Pairs>
    void pairs(const Pairs& list) {
        number(static_cast<std::int64_t>(list.size()));
        for (const auto& [name, value] : list) {
            text(name);
            text(value);
        }
    }
    std::string take() { return std::move(bytes_); }

private:
    std::string bytes_;
};

class Reader {
public:
    explicit Reader(std::string_view bytes) : rest_(bytes) {}
    std::int64_t number() {
        std::int64_t value = 0;
        std::memcpy(&value, part(sizeof value).data(), sizeof value);
        return value;
    }
    std::string text() { return std::string(part(static_cast<std::uint64_t>(number()))); }
    // Each takes bytes, so a count that is too large ends with them.
    template <class Take>
    void each(Take take) {
        for (std::int64_t left = number(); left > 0; --left) {
            std::string name = text();
            take(std::move(name), text());
        }
    }
    bool done() const { return rest_.empty(); }
    void end() const {
        if (!done()) throw std::runtime_error("a message is too long");
    }

private:
    std::string_view part(std::uint64_t size) {
        if (size > rest_.size()) throw std::runtime_error("a message is too short");
        const std::string_view first = rest_.substr(0, size);
        rest_.remove_prefix(size);
        return first;
    }
    std::string_view rest_;
};

}  // namespace

std::string packed(const Call& call) {
    Writer out;
    out.text(call.method);
    out.text(call.path);
    out.pairs(call.query);
    out.text(call.body);
    out.text(call.requestId);
    out.text(call.client);
    out.text(call.job);
    out.number(call.arrived.time_since_epoch().count());
    for (const char* name : kHeaders) out.text(call.header ? call.header(name) : "");
    return out.take();
}

Call unpackedCall(std::string_view bytes) {
    Reader in(bytes);
    Call call;
    call.method = in.text();
    call.path = in.text();
    in.each([&](std::string name, std::string value) {
        call.query.emplace(std::move(name), std::move(value));
    });
    call.body = in.text();
    call.requestId = in.text();
    call.client = in.text();
    call.job = in.text();
    call.arrived = Clock::time_point(Clock::duration(in.number()));
    std::array<std::string, kHeaders.size()> headers;
    for (std::string& value : headers) value = in.text();
    in.end();
    call.header = [headers = std::move(headers)](const char* name) -> std::string {
        for (std::size_t i = 0; i < kHeaders.size(); ++i) {
            if (std::strcmp(kHeaders[i], name) == 0) return headers[i];
        }
        return {};
    };
    return call;
}

std::string packed(const Answer& answer) {
    Writer out;
    out.number(answer.status);
    out.text(answer.type);
    out.text(answer.route);
    out.text(answer.problem);
    out.pairs(answer.headers);
    out.text(answer.body);
    return out.take();
}

std::string packed(const std::vector<std::string>& ids) {
    Writer out;
    for (const std::string& id : ids) out.text(id);
    return out.take();
}

std::vector<std::string> unpackedIds(std::string_view bytes) {
    std::vector<std::string> ids;
    for (Reader in(bytes); !in.done();) ids.push_back(in.text());
    return ids;
}

Answer unpackedAnswer(std::string_view bytes) {
    Reader in(bytes);
    Answer answer;
    answer.status = static_cast<int>(in.number());
    answer.type = in.text();
    answer.route = in.text();
    answer.problem = in.text();
    in.each([&](std::string name, std::string value) {
        answer.headers.emplace_back(std::move(name), std::move(value));
    });
    answer.body = in.text();
    in.end();
    return answer;
}

}  // namespace clerestory
