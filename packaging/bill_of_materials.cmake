# What is compiled into a wheel, with its version and licence, as CycloneDX 1.6 (JSON): the same build gives the same file.
# Needs pybind11_version, version (of cogging) and bill_of_materials (the file to write). Where
# COGGING_OWN_RUNTIME says so, the library of FMI units holds static parts of the compiler's runtime.
function(add_component name its_version licence address what)
  string(JSON component SET "{}" type "\"library\"")
  foreach(pair "bom-ref;${name}" "name;${name}" "version;${its_version}" "description;${what}")
    list(GET pair 0 key)
    list(GET pair 1 value)
    string(JSON component SET "${component}" ${key} "\"${value}\"")
  endforeach()
  string(JSON component SET "${component}" licenses "[${licence}]")
  string(JSON component SET "${component}" externalReferences "[{\"type\": \"website\", \"url\": \"${address}\"}]")
  string(JSON count LENGTH "${bill}" components)
  string(JSON bill SET "${bill}" components ${count} "${component}")
  string(JSON bill SET "${bill}" dependencies 0 dependsOn ${count} "\"${name}\"")
  set(bill "${bill}" PARENT_SCOPE)
endfunction()

set(bill "{\"$schema\": \"http://cyclonedx.org/schema/bom-1.6.schema.json\", \"bomFormat\": \"CycloneDX\",
\"specVersion\": \"1.6\", \"version\": 1, \"metadata\": {\"lifecycles\": [{\"phase\": \"build\"}], \"component\":
{\"type\": \"library\", \"bom-ref\": \"cogging\", \"name\": \"cogging\", \"version\": \"${version}\",
\"purl\": \"pkg:pypi/cogging@${version}\", \"licenses\": [{\"license\": {\"id\": \"MIT\"}}]}},
\"components\": [], \"dependencies\": [{\"ref\": \"cogging\", \"dependsOn\": []}]}")
add_component(pybind11 "${pybind11_version}" "{\"license\": {\"id\": \"BSD-3-Clause\"}}"
              "https://github.com/pybind/pybind11" "templates compiled into _core")
add_component(fdlibm 5.3 "{\"license\": {\"name\": \"fdlibm\", \"url\": \"https://www.netlib.org/fdlibm/readme\"}}"
              "https://www.netlib.org/fdlibm" "polynomials and constants of elementary.hpp")
if(MSVC)
  add_component(msvc-runtime "${CMAKE_CXX_COMPILER_VERSION}" "{\"license\": {\"name\": \"Microsoft Visual Studio\"}}"
                "https://visualstudio.microsoft.com" "static parts in the library of FMI units")
elseif(COGGING_OWN_RUNTIME)
  add_component(libstdc++ "${CMAKE_CXX_COMPILER_VERSION}"
                "{\"expression\": \"GPL-3.0-or-later WITH GCC-exception-3.1\"}" "https://gcc.gnu.org"
                "static parts of libstdc++ and libgcc in the library of FMI units")
endif()
file(WRITE "${bill_of_materials}" "${bill}\n")
