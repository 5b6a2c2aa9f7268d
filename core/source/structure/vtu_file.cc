// SPDX-License-Identifier: LGPL-2.1-or-later
#include "file_scanner.h"
#include "vtk_piece.h"

#include <feib/error.h>
#include <feib/message.h>

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <map>

namespace feib
{
  namespace
  {
    struct Tag
    {
      std::string name;
      std::map<std::string, std::string> attributes;
      bool closes = false, empty = false; // </name>, <name/>
      std::size_t line = 1, end = 0;      // where it begins, and the byte behind it

      std::string
      attribute(const std::string &key) const
      {
        const auto found = attributes.find(key);
        return found == attributes.end() ? "" : found->second;
      }
    };


    [[noreturn]] void
    fail(const std::string &file, const std::size_t line, const std::string &message)
    {
      throw Error("file \"" + file + "\", line " + std::to_string(line) + ": " + message);
    }


    /// The tags of an XML text, one after the other.
    class Tags
    {
    public:
      Tags(const std::string &file, const std::string_view text)
        : file(file)
        , text(text)
      {}

      /// Whether there is a next one.
      bool
      next(Tag &tag)
      {
        while (true)
          {
            go_to(std::min(text.find('<', at), text.size()));
            if (at == text.size())
              return false;
            const std::string_view rest = text.substr(at);
            if (rest.substr(0, 4) == "<!--")
              go_behind("-->");
            else if (rest.substr(0, 2) == "<?" || rest.substr(0, 2) == "<!")
              go_behind(">");
            else
              break;
          }
        tag      = Tag();
        tag.line = line;
        go_to(at + 1);
        tag.closes = here() == '/';
        if (tag.closes)
          go_to(at + 1);
        tag.name = name();
        while (read_attribute(tag))
          ;
        tag.end = at;
        return true;
      }

    private:
      char
      here() const
      {
        if (at >= text.size())
          fail(file, line, "the file ends inside a tag");
        return text[at];
      }

      void
      go_to(const std::size_t place)
      {
        line += std::count(text.begin() + at, text.begin() + place, '\n');
        at = place;
      }

      void
      go_behind(const char *const mark)
      {
        const std::size_t found = text.find(mark, at);
        if (found == text.npos)
          fail(file, line, "nothing ends what begins here");
        go_to(found + std::strlen(mark));
      }

      std::string
      name()
      {
        const std::size_t end = std::min(text.find_first_of(" \t\r\n/>=", at), text.size());
        const std::string result(text.substr(at, end - at));
        go_to(end);
        return result;
      }

      /// False at the end of the tag, behind which it goes.
      bool
      read_attribute(Tag &tag)
      {
        const auto skip = [this] {
          go_to(std::min(text.find_first_not_of(" \t\r\n", at), text.size()));
        };
        skip();
        if (here() == '/')
          {
            tag.empty = true;
            go_to(at + 1);
          }
        if (here() == '>')
          {
            go_to(at + 1);
            return false;
          }
        const std::string key = name();
        skip();
        const bool equals = here() == '=';
        go_to(at + 1);
        skip();
        const char quote = here();
        if (key.empty() || !equals || (quote != '"' && quote != '\''))
          fail(file,
               tag.line,
               "the tag <" + readable(tag.name, 30) +
                 "> has an attribute that is not key=\"value\"");
        const std::size_t end = text.find(quote, at + 1);
        if (end == text.npos)
          fail(file, tag.line, "the file ends inside a tag");
        tag.attributes[key] = decoded(std::string(text.substr(at + 1, end - at - 1)));
        go_to(end + 1);
        return true;
      }

      static std::string
      decoded(std::string value)
      {
        for (const auto &[entity, character] : std::map<std::string, char>{
               {"&quot;", '"'}, {"&apos;", '\''}, {"&lt;", '<'}, {"&gt;", '>'}})
          for (std::size_t i; (i = value.find(entity)) != value.npos;)
            value.replace(i, entity.size(), 1, character);
        for (std::size_t i = 0; (i = value.find("&amp;", i)) != value.npos; ++i)
          value.replace(i, 5, "&");
        return value;
      }

      const std::string file;
      const std::string_view text;
      std::size_t at = 0, line = 1;
    };


    /// Bytes, as they are or in base64, of which each group of four characters stands for itself:
    /// so parts that were encoded one by one may follow each other.
    class Bytes
    {
    public:
      Bytes(const std::string_view text, const bool base64)
        : text(text)
        , base64(base64)
      {}

      /// The next @p n ones; false when there are fewer.
      bool
      take(const std::size_t n, std::string &result)
      {
        // Whoever says that there are more gets no memory for them.
        if (n > text.size() - at + rest.size())
          return false;
        result = rest.substr(0, n);
        rest.erase(0, n);
        if (!base64)
          {
            result += text.substr(at, n - result.size());
            at += n;
            return result.size() == n;
          }
        std::string group;
        while (result.size() < n && next_group(group))
          result += group;
        if (result.size() < n)
          return false;
        rest = result.substr(n);
        result.resize(n);
        return true;
      }

    private:
      /// One to three bytes.
      bool
      next_group(std::string &group)
      {
        std::array<int, 4> values;
        for (int &value : values)
          {
            while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at])))
              ++at;
            if (at == text.size() || (value = value_of(text[at++])) == invalid)
              return false;
          }
        const auto [a, b, c, d] = values;
        if (a == padding || b == padding || (c == padding && d != padding))
          return false;
        group = char(a << 2 | b >> 4);
        if (c != padding)
          group += char((b & 15) << 4 | c >> 2);
        if (d != padding)
          group += char((c & 3) << 6 | d);
        return true;
      }

      static int
      value_of(const char c)
      {
        return c >= 'A' && c <= 'Z'   ? c - 'A'
               : c >= 'a' && c <= 'z' ? c - 'a' + 26
               : c >= '0' && c <= '9' ? c - '0' + 52
               : c == '+'             ? 62
               : c == '/'             ? 63
               : c == '='             ? padding
                                      : invalid;
      }

      static constexpr int padding = 64, invalid = 65;
      const std::string_view text;
      const bool base64;
      std::size_t at = 0;
      std::string rest; // of the last group
    };


    class Reader
    {
    public:
      Reader(const std::string &file, const std::string_view text)
        : file(file)
        , text(text)
      {
        find_arrays();
        std::uint64_t n_cells = 0;
        for (std::size_t p = 0; p < pieces.size(); ++p)
          {
            const VtkPiece piece = read_piece(p);
            try
              {
                piece.add_to(result, n_cells);
              }
            catch (const Error &error)
              {
                fail(file, pieces[p].line, "of this piece, " + error.issues().front().message);
              }
          }
      }

      MeshFile result;

    private:
      struct Array
      {
        std::size_t piece;
        std::string group; // the tag that it stands in
        Tag tag;
      };

      static std::string
      quoted(const std::string &found)
      {
        return '"' + readable(found, 30) + '"';
      }

      std::size_t
      count(const Tag &tag, const std::string &key) const
      {
        const std::string value = tag.attribute(key);
        std::size_t number      = 0;
        const auto [end, problem] =
          std::from_chars(value.data(), value.data() + value.size(), number);
        if (problem != std::errc() || end != value.data() + value.size())
          fail(file, tag.line, "found " + quoted(value) + " where a number is expected for " + key);
        return number;
      }

      void
      read_head(const Tag &tag)
      {
        const std::string type = tag.attribute("type"), order = tag.attribute("byte_order"),
                          header     = tag.attribute("header_type"),
                          compressor = tag.attribute("compressor");
        if (tag.name != "VTKFile" || type != "UnstructuredGrid")
          fail(file,
               tag.line,
               "found <" + readable(tag.name, 30) + "> of the type " + quoted(type) +
                 "; Feib reads <VTKFile type=\"UnstructuredGrid\">");
        if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
          fail(file,
               tag.line,
               "its arrays are compressed by " + quoted(compressor) +
                 "; Feib reads vtkZLibDataCompressor and arrays that are not compressed");
        if (!header.empty() && header != "UInt32" && header != "UInt64")
          fail(file,
               tag.line,
               "found the header_type " + quoted(header) + "; it is UInt32 or UInt64");
        const std::uint16_t one = 1;
        char first;
        std::memcpy(&first, &one, 1);
        swapped     = (order == "BigEndian") == (first == 1);
        compressed  = !compressor.empty();
        header_size = {header == "UInt64" ? 8u : 4u, true, false};
      }

      void
      find_arrays()
      {
        Tags tags(file, text);
        Tag tag;
        std::string group;
        bool begun = false, ended = false;
        while (!ended && tags.next(tag))
          {
            if (!begun)
              read_head(tag);
            begun = true;
            ended = tag.closes && tag.name == "VTKFile";
            if (tag.closes)
              {
                if (tag.name == group)
                  group.clear();
              }
            else if (tag.name == "Piece")
              pieces.push_back(tag);
            else if (tag.name == "Points" || tag.name == "Cells" || tag.name == "CellData" ||
                     tag.name == "PointData" || tag.name == "FieldData")
              group = tag.empty ? "" : tag.name;
            else if (tag.name == "DataArray" && !pieces.empty())
              arrays.push_back({pieces.size() - 1, group, tag});
            else if (tag.name == "AppendedData")
              {
                find_appended(tag);
                return;
              }
          }
        if (!ended)
          fail(file, tag.line, "the file ends without </VTKFile>");
      }

      void
      find_appended(const Tag &tag)
      {
        const std::string encoding = tag.attribute("encoding");
        if (encoding != "raw" && encoding != "base64")
          fail(file,
               tag.line,
               "the appended data are encoded as " + quoted(encoding) +
                 "; Feib reads raw and base64");
        base64                  = encoding == "base64";
        const std::size_t begin = text.find_first_not_of(" \t\r\n", tag.end);
        const std::size_t end   = text.rfind("</AppendedData>");
        if (begin == text.npos || text[begin] != '_' || end == text.npos || end < begin ||
            text.find("</VTKFile>", end) == text.npos)
          fail(file,
               tag.line,
               "the appended data should begin with _ and end with </AppendedData></VTKFile>");
        appended     = text.substr(begin + 1, end - begin - 1);
        has_appended = true;
      }

      VtkPiece
      read_piece(const std::size_t p) const
      {
        VtkPiece piece;
        const Tag &tag             = pieces[p];
        const std::size_t n_points = count(tag, "NumberOfPoints"),
                          n_cells  = count(tag, "NumberOfCells");
        bool has_points            = false;
        for (const Array &array : arrays)
          {
            if (array.piece != p)
              continue;
            const std::string name = array.tag.attribute("Name");
            if (array.group == "Points")
              {
                piece.points = numbers(array.tag).values;
                has_points   = true;
              }
            else if (array.group == "Cells" && name == "connectivity")
              piece.connectivity = numbers(array.tag).values;
            else if (array.group == "Cells" && name == "offsets")
              piece.ends = numbers(array.tag).values;
            else if (array.group == "Cells" && name == "types")
              piece.types = numbers(array.tag).values;
            else if (array.group == "CellData")
              piece.cell_data.push_back(numbers(array.tag));
          }
        const auto check =
          [&](const std::string &what, const std::size_t said, const double there) {
            if (said != there)
              fail(file,
                   tag.line,
                   "this piece says that it has " + std::to_string(said) + " " + what +
                     ", its arrays have " + readable(there));
          };
        check("points", n_points, has_points ? piece.points.size() / 3. : 0);
        check("cells", n_cells, piece.ends.size());
        return piece;
      }

      VtkNumber
      type_of(const Tag &tag) const
      {
        static const std::map<std::string, VtkNumber> types{{"Int8", {1, true, true}},
                                                            {"UInt8", {1, true, false}},
                                                            {"Int16", {2, true, true}},
                                                            {"UInt16", {2, true, false}},
                                                            {"Int32", {4, true, true}},
                                                            {"UInt32", {4, true, false}},
                                                            {"Int64", {8, true, true}},
                                                            {"UInt64", {8, true, false}},
                                                            {"Float32", {4, false, true}},
                                                            {"Float64", {8, false, true}}};
        const auto found = types.find(tag.attribute("type"));
        if (found == types.end())
          fail(file,
               tag.line,
               "found an array of the type " + quoted(tag.attribute("type")) +
                 "; it is Int8, ..., UInt64, Float32 or Float64");
        return found->second;
      }

      VtkArray
      numbers(const Tag &tag) const
      {
        VtkArray result;
        const VtkNumber type = type_of(tag);
        result.name          = tag.attribute("Name");
        result.integer       = type.integer;
        if (tag.attributes.count("NumberOfComponents") > 0)
          result.n_components = count(tag, "NumberOfComponents");
        const std::string_view body = body_of(tag);
        if (tag.attribute("format") == "ascii")
          {
            FileScanner in(file, body);
            in.line    = tag.line;
            in.section = "the array " + quoted(result.name);
            while (in.find_word())
              result.values.push_back(in.real(false));
            return result;
          }
        const std::string bytes = bytes_of(tag, source_of(tag));
        if (bytes.size() % type.size != 0)
          fail(file,
               tag.line,
               "the array " + quoted(result.name) + " has " + std::to_string(bytes.size()) +
                 " bytes, which is no number of " + tag.attribute("type"));
        result.values.reserve(bytes.size() / type.size);
        for (std::size_t i = 0; i < bytes.size(); i += type.size)
          result.values.push_back(type.value(bytes.data() + i, swapped));
        return result;
      }

      /// What stands behind its tag.
      std::string_view
      body_of(const Tag &tag) const
      {
        const std::size_t end = std::min(text.find('<', tag.end), text.size());
        return text.substr(tag.end, tag.empty ? 0 : end - tag.end);
      }

      /// Where the bytes of an array begin.
      Bytes
      source_of(const Tag &tag) const
      {
        const std::string format = tag.attribute("format"),
                          array  = "the array " + quoted(tag.attribute("Name"));
        if (format == "binary")
          return Bytes(body_of(tag), true);
        if (format != "appended" || !has_appended)
          fail(file,
               tag.line,
               array + " has the format " + quoted(format) +
                 (format == "appended" ? ", but the file has no <AppendedData>"
                                       : "; it is ascii, binary or appended"));
        const std::size_t offset = count(tag, "offset");
        if (offset > appended.size())
          fail(file,
               tag.line,
               array + " begins at the byte " + std::to_string(offset) +
                 " of the appended data, which have " + std::to_string(appended.size()));
        return Bytes(appended.substr(offset), base64);
      }

      /// Of an array: their number, then they; or the numbers of blocks and of the bytes in each,
      /// then these compressed.
      std::string
      bytes_of(const Tag &tag, Bytes source) const
      {
        const std::string array = "the array " + quoted(tag.attribute("Name"));
        const auto take         = [&](const std::size_t n) {
          std::string bytes;
          if (!source.take(n, bytes))
            fail(file,
                 tag.line,
                 array + " is shorter than it says, or not in the encoding that it says");
          return bytes;
        };
        const auto size = [&] {
          const double n = header_size.value(take(header_size.size).data(), swapped);
          return n < 1e18 ? std::size_t(n) : std::numeric_limits<std::size_t>::max();
        };
        if (!compressed)
          return take(size());
        const std::size_t n_blocks = size(), block = size(), last = size();
        std::vector<std::size_t> sizes; // grows with what is read
        for (std::size_t b = 0; b < n_blocks; ++b)
          sizes.push_back(size());
        std::string result;
        for (std::size_t b = 0; b < n_blocks; ++b)
          {
            const std::size_t n         = b + 1 == n_blocks && last > 0 ? last : block;
            const std::string from      = take(sizes[b]);
            const std::size_t beginning = result.size();
            // No compression by zlib is better than 1 to 1032.
            if (n / 1100 > from.size() + 1)
              fail(file,
                   tag.line,
                   array + " has a compressed block that is too short for its size");
            result.resize(beginning + n);
            uLongf there = n;
            if (uncompress(reinterpret_cast<Bytef *>(result.data() + beginning),
                           &there,
                           reinterpret_cast<const Bytef *>(from.data()),
                           from.size()) != Z_OK ||
                there != n)
              fail(file, tag.line, array + " has a compressed block that zlib cannot read");
          }
        return result;
      }

      const std::string file;
      const std::string_view text;
      bool compressed = false, swapped = false, base64 = false, has_appended = false;
      VtkNumber header_size{4, true, false};
      std::vector<Tag> pieces;
      std::vector<Array> arrays;
      std::string_view appended;
    };
  } // namespace


  MeshFile
  read_vtu(const std::string &name, const std::string_view text)
  {
    return Reader(name, text).result;
  }
} // namespace feib
