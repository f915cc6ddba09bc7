// Who may ask: host names that a browser cannot be tricked with, an optional token, signed links.
// Answers no route, and tells nobody which part of a secret was wrong.
#pragma once

#include "server/http/exchange.h"

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace clerestory {

struct AccessOptions {
    std::vector<std::string> hosts;  // names beside localhost and every address; "*": any
    std::string tokenFile;           // empty: no token is asked for
    std::string linkKeyFile;         // empty: links are not signed
    std::string clientHeader;        // of a proxy in front, that names its client; empty: none
};

class Access {
public:
    using Seconds = std::chrono::sys_seconds;
    struct Paths {
        std::function<bool(std::string_view path)> open;    // for everybody: health, the page
        std::function<bool(std::string_view path)> linked;  // whose GET a signed link opens
    };

    // Reads the files. Throws std::runtime_error with one line when one is missing or has less than
    // 16 bytes.
    Access(const AccessOptions& options, Paths paths);

    // Why not: 421 host, 401 token, 403 link. Takes as long for every wrong secret.
    std::optional<Problem> refusal(const RequestHead& head, Seconds now) const;

    // Whom a request counts for: its address, or the last name in the proxy's header.
    std::string clientOf(const RequestHead& head, const std::string& address) const;

private:
    bool hostIsOurs(std::string_view host) const;
    bool tokenIsRight(const RequestHead& head) const;
    std::optional<Problem> linkRefusal(const RequestHead& head, Seconds now) const;

    const AccessOptions options_;
    const Paths paths_;
    std::string token_, linkKey_;
};

// The first line of a file of at least 16 bytes. Throws std::runtime_error with one line.
std::string secretFrom(const std::string& file);

// The target with "expires" and "signature" (HMAC-SHA-256 over all before it) behind its query.
std::string signedLink(const std::string& key, const std::string& target, Access::Seconds expires);

}  // namespace clerestory
