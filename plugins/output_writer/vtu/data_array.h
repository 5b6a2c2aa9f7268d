// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_vtu_data_array_h
#define feib_vtu_data_array_h

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <zlib.h>

namespace feib
{
  /// The element <DataArray> of a vtu file that says compressor="vtkZLibDataCompressor": base64 of
  /// (blocks, bytes of a block, bytes of the last, compressed bytes of each) in 32 bits, then of
  /// the zlib streams of all blocks. @p name: empty for the points. Values: double, std::int32_t or
  /// std::uint8_t. @p block: the most bytes in one.
  template <typename T>
  std::string
  data_array(const std::string &name,
             const unsigned int n_components,
             const std::vector<T> &values,
             const std::size_t block = std::size_t(1) << 30)
  {
    const std::string type    = std::is_same_v<T, double>         ? "Float64"
                                : std::is_same_v<T, std::int32_t> ? "Int32"
                                                                  : "UInt8";
    const std::size_t n_bytes = values.size() * sizeof(T);
    const std::size_t n       = std::max<std::size_t>(1, (n_bytes + block - 1) / block);
    std::vector<std::uint32_t> sizes{std::uint32_t(n),
                                     std::uint32_t(std::min(n_bytes, block)),
                                     std::uint32_t(n_bytes - (n - 1) * block)};
    std::vector<unsigned char> packed;
    for (std::size_t k = 0; k < n; ++k)
      {
        const uLong length      = k + 1 < n ? block : sizes[2];
        uLongf n_packed         = compressBound(length);
        const std::size_t begin = packed.size();
        packed.resize(begin + n_packed);
        const int status = compress2(packed.data() + begin,
                                     &n_packed,
                                     reinterpret_cast<const Bytef *>(values.data()) + k * block,
                                     length,
                                     Z_BEST_SPEED);
        if (status != Z_OK)
          throw std::runtime_error("zlib cannot compress an array of " + std::to_string(n_bytes) +
                                   " bytes (error " + std::to_string(status) + ")");
        packed.resize(begin + n_packed);
        sizes.push_back(n_packed);
      }
    std::vector<unsigned char> head(sizes.size() * sizeof(sizes[0]));
    std::memcpy(head.data(), sizes.data(), head.size());
    return "<DataArray type=\"" + type + "\"" + (name.empty() ? "" : " Name=\"" + name + "\"") +
           " NumberOfComponents=\"" + std::to_string(n_components) + "\" format=\"binary\">\n" +
           dealii::Utilities::encode_base64(head) + dealii::Utilities::encode_base64(packed) +
           "\n</DataArray>\n";
  }
} // namespace feib

#endif
