// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_vtu_data_array_h
#define feib_vtu_data_array_h

#include <deal.II/base/utilities.h>

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
  /// (blocks, bytes of a block, bytes of the last, compressed bytes), then of one zlib stream.
  /// @p name: empty for the points. Values: double, std::int32_t or std::uint8_t.
  template <typename T>
  std::string
  data_array(const std::string &name, const unsigned int n_components, const std::vector<T> &values)
  {
    const std::string type = std::is_same_v<T, double>         ? "Float64"
                             : std::is_same_v<T, std::int32_t> ? "Int32"
                                                               : "UInt8";
    const uLong n_bytes    = values.size() * sizeof(T);
    uLongf n_packed        = compressBound(n_bytes);
    std::vector<unsigned char> packed(n_packed);
    const int status = compress2(packed.data(),
                                 &n_packed,
                                 reinterpret_cast<const Bytef *>(values.data()),
                                 n_bytes,
                                 Z_BEST_SPEED);
    if (status != Z_OK)
      throw std::runtime_error("zlib cannot compress an array of " + std::to_string(n_bytes) +
                               " bytes (error " + std::to_string(status) + ")");
    packed.resize(n_packed);
    const std::uint32_t sizes[] = {1,
                                   std::uint32_t(n_bytes),
                                   std::uint32_t(n_bytes),
                                   std::uint32_t(n_packed)};
    std::vector<unsigned char> head(sizeof(sizes));
    std::memcpy(head.data(), sizes, sizeof(sizes));
    return "<DataArray type=\"" + type + "\"" + (name.empty() ? "" : " Name=\"" + name + "\"") +
           " NumberOfComponents=\"" + std::to_string(n_components) + "\" format=\"binary\">\n" +
           dealii::Utilities::encode_base64(head) + dealii::Utilities::encode_base64(packed) +
           "\n</DataArray>\n";
  }
} // namespace feib

#endif
