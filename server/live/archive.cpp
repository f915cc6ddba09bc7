#include "server/live/archive.h"

#include <archive.h>
#include <archive_entry.h>

namespace clerestory {
namespace {

class Tar final : public Archive {
public:
    explicit Tar(const Sink& sink) : sink_(sink), out_(archive_write_new()) {
        archive_write_set_format_pax_restricted(out_);  // plain ustar where that can say it
        archive_write_set_bytes_per_block(out_, 0);     // every file leaves at once
        archive_write_open(out_, this, nullptr, &Tar::write, nullptr);
    }
    ~Tar() override { archive_write_free(out_); }
    Tar(const Tar&) = delete;
    Tar& operator=(const Tar&) = delete;

    bool add(const std::string& name, const std::string&, std::string_view bytes) override {
        archive_entry* entry = archive_entry_new();
        archive_entry_set_pathname(entry, name.c_str());
        archive_entry_set_size(entry, static_cast<la_int64_t>(bytes.size()));
        archive_entry_set_filetype(entry, AE_IFREG);
        archive_entry_set_perm(entry, 0644);
        archive_entry_set_mtime(entry, 0, 0);
        const bool written = archive_write_header(out_, entry) == ARCHIVE_OK &&
                             archive_write_data(out_, bytes.data(), bytes.size()) ==
                                 static_cast<la_ssize_t>(bytes.size()) &&
                             archive_write_finish_entry(out_) == ARCHIVE_OK;
        archive_entry_free(entry);
        return written && !left_;
    }

    bool end() override { return archive_write_close(out_) == ARCHIVE_OK && !left_; }

private:
    static la_ssize_t write(struct archive*, void* self, const void* bytes, std::size_t size) {
        auto* tar = static_cast<Tar*>(self);
        // Once the client has left nothing is written, not even the end that free() adds.
        // libarchive is not notified: after a failure its free() forgets 33 bytes (3.6.2).
        if (!tar->left_) {
            tar->left_ = !tar->sink_({static_cast<const char*>(bytes), size});
        }
        return static_cast<la_ssize_t>(size);
    }

    const Sink& sink_;
    struct archive* out_;
    bool left_ = false;
};

class Multipart final : public Archive {
public:
    explicit Multipart(const Sink& sink) : sink_(sink) {}

    bool add(const std::string& name, const std::string& type, std::string_view bytes) override {
        return sink_("--clerestory-sequence\r\nContent-Type: " + type +
                     "\r\nContent-Disposition: attachment; filename=\"" + name +
                     "\"\r\nContent-Length: " + std::to_string(bytes.size()) + "\r\n\r\n") &&
               sink_(bytes) && sink_("\r\n");
    }
    bool end() override { return sink_("--clerestory-sequence--\r\n"); }

private:
    const Sink& sink_;
};

}  // namespace

std::unique_ptr<Archive> tarArchive(const Sink& sink) {
    return std::make_unique<Tar>(sink);
}
std::unique_ptr<Archive> multipartArchive(const Sink& sink) {
    return std::make_unique<Multipart>(sink);
}

}  // namespace clerestory
