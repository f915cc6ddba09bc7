// Preloaded into a server: every other accept4() fails, with each of the errors that accept(2)
// lists in turn. The connection stays in the backlog, as it does when the kernel lacks a resource.
#include <dlfcn.h>
#include <sys/socket.h>

#include <atomic>
#include <cerrno>
#include <iterator>

extern "C" int accept4(int socket, sockaddr* address, socklen_t* size, int flags) {
    using Accept = int (*)(int, sockaddr*, socklen_t*, int);
    static const auto real = reinterpret_cast<Accept>(dlsym(RTLD_NEXT, "accept4"));
    static std::atomic<unsigned> calls{0};
    constexpr int kErrors[] = {ENFILE, ENOMEM, ECONNABORTED, EMFILE,   ENOBUFS,
                               EPERM,  EPROTO, EINTR,        ENETDOWN, EINVAL};
    const unsigned call = calls++;
    if (call % 2 == 0) {
        errno = kErrors[call / 2 % std::size(kErrors)];
        return -1;
    }
    return real(socket, address, size, flags);
}
