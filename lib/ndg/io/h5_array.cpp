// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/h5_array.h"

#include "ndg/core/error.h"
#include "ndg/io/h5_guard.h"
#include "ndg/io/h5_handles.h"

namespace ndg {

NpyArray read_h5_array(const std::string& path, const std::string& name)
{
    h5::silence_errors();
    const h5::ReadingGuard guard(path, false);
    const h5::Handle file = h5::open_file(path);
    const h5::Handle dataset = h5::open_dataset(file, path, name);
    const h5::Handle type(H5Dget_type(dataset), H5Tclose);
    const H5T_class_t type_class = H5Tget_class(type);
    require_input(type_class == H5T_FLOAT || type_class == H5T_INTEGER, "{}: dataset {} holds {}, expected numbers",
                  path, name, h5::type_name(type));
    h5::check_stored_size(dataset, path, name);
    NpyArray array;
    std::size_t count = 1;
    for (const std::size_t extent : h5::dataset_shape(dataset)) {
        array.shape.push_back(static_cast<std::int64_t>(extent));
        count *= extent;
    }
    array.values.resize(count);
    require_input(
        count == 0 || H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()) >= 0,
        "{}: cannot read dataset {}, truncated or damaged ({})", path, name, h5::last_error());
    return array;
}

}  // namespace ndg
