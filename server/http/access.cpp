#include "server/http/access.h"

#include <arpa/inet.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <fstream>

namespace clerestory {
namespace {

using Digest = std::array<unsigned char, 32>;

constexpr std::size_t kMinSecret = 16;
constexpr std::string_view kSignature = "&signature=", kExpires = "expires=";

Digest hmac(const std::string& key, std::string_view text) {
    Digest digest{};
    unsigned int size = 0;
    HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()),
         reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data(), &size);
    return digest;
}

// Compares in constant time, whatever the lengths.
bool equalInConstantTime(std::string_view a, std::string_view b) {
    static const std::string key = "compares";
    const Digest x = hmac(key, a), y = hmac(key, b);
    return CRYPTO_memcmp(x.data(), y.data(), x.size()) == 0;
}

std::string hexOf(const Digest& digest) {
    std::string text;
    for (const unsigned char byte : digest) {
        text += "0123456789abcdef"[byte >> 4];
        text += "0123456789abcdef"[byte & 15];
    }
    return text;
}

std::string lower(std::string_view text) {
    std::string low(text);
    std::transform(low.begin(), low.end(), low.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return low;
}

// Without the port, and without the brackets of IPv6.
std::string nameIn(std::string_view host) {
    if (host.starts_with('[')) return lower(host.substr(1, host.find(']') - 1));
    return lower(host.substr(0, host.find(':')));
}

// Of an IPv6 address the network of 64 bits, since its user chooses the rest; other names as they
// are. Some proxies write a port, or brackets.
std::string networkOf(const std::string& name) {
    const bool bracketed = name.starts_with('[');
    const std::string host = bracketed ? name.substr(1, name.find(']') - 1) : name;
    in6_addr address{};
    if (inet_pton(AF_INET6, host.c_str(), &address) != 1) {
        const std::size_t colon = name.find(':');
        return name.find(':', colon + 1) == std::string::npos ? name.substr(0, colon) : name;
    }
    char text[INET6_ADDRSTRLEN] = "";
    if (IN6_IS_ADDR_V4MAPPED(&address)) {
        return inet_ntop(AF_INET, address.s6_addr + 12, text, sizeof text) ? text : host;
    }
    if (!IN6_IS_ADDR_LOOPBACK(&address)) {
        std::fill(address.s6_addr + 8, address.s6_addr + 16, std::uint8_t{0});
    }
    return inet_ntop(AF_INET6, &address, text, sizeof text) ? text : host;
}

bool isAddress(const std::string& name) {
    in6_addr address{};
    return inet_pton(AF_INET, name.c_str(), &address) == 1 ||
           inet_pton(AF_INET6, name.c_str(), &address) == 1;
}

}  // namespace

std::string secretFrom(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string secret;
    if (!stream || !std::getline(stream, secret)) {
        throw std::runtime_error("cannot read a secret from " + file);
    }
    if (secret.starts_with("\xEF\xBB\xBF")) secret.erase(0, 3);  // byte order mark
    while (!secret.empty() && (secret.back() == '\r' || secret.back() == ' ')) secret.pop_back();
    if (secret.size() < kMinSecret) {
        throw std::runtime_error("the secret in " + file + " is shorter than " +
                                 std::to_string(kMinSecret) + " bytes");
    }
    return secret;
}

std::string signedLink(const std::string& key, const std::string& target, Access::Seconds expires) {
    const std::string whole = target + (target.find('?') == std::string::npos ? "?" : "&") +
                              std::string(kExpires) +
                              std::to_string(expires.time_since_epoch().count());
    return whole + std::string(kSignature) + hexOf(hmac(key, whole));
}

Access::Access(const AccessOptions& options, Paths paths)
    : options_(options), paths_(std::move(paths)) {
    if (!options.tokenFile.empty()) token_ = secretFrom(options.tokenFile);
    if (!options.linkKeyFile.empty()) linkKey_ = secretFrom(options.linkKeyFile);
}

// DNS rebinding lets a foreign page send requests to this server under the page's own host name,
// but never under an IP address.
bool Access::hostIsAllowed(std::string_view host) const {
    const std::string name = nameIn(host);
    if (name == "localhost" || isAddress(name)) return true;
    return std::any_of(
        options_.hosts.begin(), options_.hosts.end(),
        [&](const std::string& allowed) { return allowed == "*" || lower(allowed) == name; });
}

bool Access::tokenIsValid(const RequestHead& head) const {
    constexpr std::string_view kScheme = "bearer ";
    const std::string_view given = head.header("Authorization");
    const bool bearer = lower(given.substr(0, kScheme.size())) == kScheme;
    return equalInConstantTime(bearer ? given.substr(kScheme.size()) : std::string_view(), token_);
}

std::optional<Problem> Access::linkRefusal(const RequestHead& head, Seconds now) const {
    const std::string_view target = head.target;
    const std::size_t end = target.rfind(kSignature);
    if (end == std::string_view::npos) return forbidden("This link is not signed.");
    const std::string_view text = target.substr(0, end);
    if (!equalInConstantTime(target.substr(end + kSignature.size()), hexOf(hmac(linkKey_, text)))) {
        return forbidden("The signature of this link is invalid.");
    }
    std::int64_t expires = 0;  // a link without it has expired
    const std::size_t from = text.rfind(kExpires);
    if (from != std::string_view::npos) {
        std::from_chars(text.data() + from + kExpires.size(), text.data() + text.size(), expires);
    }
    if (now.time_since_epoch().count() > expires) return forbidden("This link has expired.");
    return std::nullopt;
}

std::optional<Problem> Access::refusal(const RequestHead& head, Seconds now) const {
    const std::string_view host = head.header("Host");
    if (!host.empty() && !hostIsAllowed(host)) return misdirected();
    if (paths_.open(head.path())) return std::nullopt;
    const bool reads = head.method == "GET" || head.method == "HEAD";
    if (!linkKey_.empty() && reads && paths_.linked(head.path())) {
        if (!token_.empty() && tokenIsValid(head)) return std::nullopt;
        return linkRefusal(head, now);
    }
    // Without a token only signed links are answered: everything else could draw frames, too,
    // or say what there is to draw.
    if (token_.empty() && !linkKey_.empty()) {
        return forbidden("This server answers signed links to frames only.");
    }
    if (token_.empty() || tokenIsValid(head)) return std::nullopt;
    return unauthorized();
}

std::string Access::clientOf(const RequestHead& head, const std::string& address) const {
    if (options_.clientHeader.empty()) return address;
    // The last line and its last entry: the client itself may have written what precedes them.
    std::string_view names;
    for (const auto& [name, value] : head.headers) {
        if (lower(name) == lower(options_.clientHeader)) names = value;
    }
    const std::size_t comma = names.rfind(',');
    if (comma != std::string_view::npos) names.remove_prefix(comma + 1);
    while (!names.empty() && names.front() == ' ') names.remove_prefix(1);
    while (!names.empty() && names.back() == ' ') names.remove_suffix(1);
    return names.empty() ? address : networkOf(std::string(names.substr(0, 64)));
}

}  // namespace clerestory
