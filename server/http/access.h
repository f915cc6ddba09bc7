// Access control: allowed host names (against DNS rebinding), an optional token, signed links.
// Responses never reveal which part of a secret was wrong.
#pragma once

#include "server/http/exchange.h"

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace clerestory {

struct AccessOptions {
    std::vector<std::string> hosts;    // names allowed besides localhost and IP addresses; "*": any
    std::vector<std::string> origins;  // of other pages that may read answers; see CrossOrigin
    std::string tokenFile;             // empty: no token is required
    std::string linkKeyFile;           // empty: links are not signed
    std::string clientHeader;          // header in which a reverse proxy names its client; or empty
};

class Access {
public:
    using Seconds = std::chrono::sys_seconds;
    struct Paths {
        std::function<bool(std::string_view path)> open;    // needs no token: health, the page
        std::function<bool(std::string_view path)> linked;  // GET is allowed with a signed link
    };

    // Reads the files. Throws std::runtime_error if one is missing or shorter than 16 bytes.
    Access(const AccessOptions& options, Paths paths);

    // 421 for the host, 401 for the token, 403 for the link, or nothing if the request is allowed.
    // Secrets are compared in constant time.
    std::optional<Problem> refusal(const RequestHead& head, Seconds now) const;

    // The client for fair shares: the address, or the last name in the last line of the proxy's
    // header. An IPv6 address counts as its network of 64 bits.
    std::string clientOf(const RequestHead& head, const std::string& address) const;

private:
    bool hostIsAllowed(std::string_view host) const;
    bool tokenIsValid(const RequestHead& head) const;
    std::optional<Problem> linkRefusal(const RequestHead& head, Seconds now) const;

    const AccessOptions options_;
    const Paths paths_;
    std::string token_, linkKey_;
};

// The first line of the file, at least 16 bytes. Throws std::runtime_error.
std::string secretFrom(const std::string& file);

// The target with "expires" and "signature" (HMAC-SHA-256 of everything before it) appended to its
// query.
std::string signedLink(const std::string& key, const std::string& target, Access::Seconds expires);

}  // namespace clerestory
