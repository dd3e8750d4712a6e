/* Files and data URIs. tinygltf's own loader also searches the working directory, reads '+' as a blank and
 * refuses a file that is longer than its buffer; glTF wants none of that. */
#include "io/gltf.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace gltf
{

namespace
{

int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    if (c >= 'A' && c <= 'F')
        return c - 'A' + 10;
    return -1;
}

std::string decode_percent(const char *text)
{
    std::string out;
    for (const char *c = text; *c; c++) {
        int high = *c == '%' ? hex_digit(c[1]) : -1;
        int low = high >= 0 ? hex_digit(c[2]) : -1;
        if (low >= 0) {
            out += static_cast<char>(16 * high + low);
            c += 2;
        } else {
            out += *c;
        }
    }
    return out;
}

int base64_digit(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = c ? std::strchr(digits, c) : nullptr;
    return at ? static_cast<int>(at - digits) : -1;
}

/* False if a character is not base64. */
bool decode_base64(const char *text, bytes &out)
{
    unsigned group = 0, bits = 0;
    size_t length = std::strlen(text);
    while (length && text[length - 1] == '=')
        length--;
    out.reserve(length / 4 * 3 + 3);
    for (size_t i = 0; i < length; i++) {
        int digit = base64_digit(text[i]);
        if (digit < 0)
            return false;
        group = (group << 6 | static_cast<unsigned>(digit)) & 0xffffff;
        bits += 6;
        if (bits >= 8) {
            bits -= 8;
            out.push_back(static_cast<unsigned char>(group >> bits));
        }
    }
    return true;
}

bytes decode_data(const document &doc, const char *uri, const std::string &what)
{
    const char *comma = std::strchr(uri, ',');
    if (!comma)
        fail(doc, HPR_ERR_FORMAT, "%s: data URI without a comma", what.c_str());
    bytes out;
    std::string header(uri, comma);
    if (header.size() >= 7 && header.compare(header.size() - 7, 7, ";base64") == 0) {
        if (!decode_base64(comma + 1, out))
            fail(doc, HPR_ERR_FORMAT, "%s: data URI is not base64", what.c_str());
    } else {
        std::string plain = decode_percent(comma + 1);
        out.assign(plain.begin(), plain.end());
    }
    return out;
}

} // namespace

bytes read_file(const document &doc, const std::string &path, const std::string &what, size_t limit)
{
    const size_t step = 1 << 20;
    std::string prefix = what.empty() ? "" : what + ": '" + path + "' ";
    std::unique_ptr<FILE, int (*)(FILE *)> file(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!file || path.size() != std::strlen(path.c_str()))
        fail(doc, HPR_ERR_IO, "%scannot be read: %s", prefix.c_str(), std::strerror(file ? EINVAL : errno));
    bytes out;
    size_t got = 1;
    while (got && out.size() < limit) {
        size_t old = out.size(), want = std::min(limit - old, std::max(step, old));
        out.resize(old + want);
        got = std::fread(out.data() + old, 1, want, file.get());
        out.resize(old + got);
    }
    if (std::ferror(file.get()))
        fail(doc, HPR_ERR_IO, "%scannot be read: %s", prefix.c_str(), std::strerror(errno));
    return out;
}

bytes load_uri(const document &doc, const char *uri, const std::string &what, size_t limit)
{
    if (std::strncmp(uri, "data:", 5) == 0)
        return decode_data(doc, uri, what);
    if (std::strstr(uri, "://"))
        fail(doc, HPR_ERR_UNSUPPORTED, "%s: '%s' is not a relative file name", what.c_str(), uri);
    std::string path = decode_percent(uri);
    size_t slash = doc.path.rfind('/');
    if (slash != std::string::npos && path.compare(0, 1, "/") != 0)
        path = doc.path.substr(0, slash + 1) + path;
    return read_file(doc, path, what, limit);
}

} // namespace gltf
