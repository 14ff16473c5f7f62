#!/usr/bin/env python3
"""
install.py BUILD PREFIX CC SOURCE_ROOT: what is installed is in its places, and a program finds csm in each way that
there is: pkg-config, CMake (where it is installed), and Meson with csm as a subproject. The last one links it both
ways.
"""
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile

build, prefix, cc, source = sys.argv[1], pathlib.PurePath(sys.argv[2]), shlex.split(sys.argv[3]), pathlib.Path(sys.argv[4])
PROGRAM = """#include <csm/csm.h>
int main(void) { return csm_version() == CSM_VERSION ? 0 : 1; }
"""
INCLUDES = {"csm_constants.h", "csm_sample.glsl", "csm_sample.hlsl"}
CMAKE = """cmake_minimum_required(VERSION 3.16)
project(engine C)
find_package(csm 1 REQUIRED)
get_target_property(shaders csm::csm CSM_SHADER_INCLUDE_DIR)
get_target_property(backends csm::csm CSM_BACKEND_DIR)
if(NOT shaders STREQUAL csm_SHADER_INCLUDE_DIR OR NOT backends STREQUAL csm_BACKEND_DIR)
  message(FATAL_ERROR "the variables and the target's properties differ")
endif()
file(WRITE "${CMAKE_BINARY_DIR}/folders" "${csm_SHADER_INCLUDE_DIR}\\n${csm_BACKEND_DIR}\\n")
add_executable(program program.c)
target_link_libraries(program PRIVATE csm::csm)
"""
# Where a library that is linked into a program looks for backends, when there are none.
WHERE = """#include <csm/csm.h>
#include <stdio.h>
int main(void) {
  uint32_t count = 1;
  csm_backend_info info = {.struct_size = sizeof info};
  csm_query_backends(&count, &info);
  puts(info.error);
}
"""
MESON = """project('engine', 'c')
shared = dependency('csm', fallback: 'csm', default_options: 'default_library=both')
static = subproject('csm').get_variable('csm_static_dep')
foreach name, way : {'shared': shared, 'static': static}
  executable(name, 'program.c', dependencies: way)
endforeach
executable('where', 'where.c', dependencies: static)
assert(import('fs').exists(shared.get_variable('shaderdir') / 'csm_constants.h'))
"""


def run(*command, **options):
    done = subprocess.run([str(part) for part in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          **options)
    if done.returncode:
        sys.exit(f"{done.stdout}\nfailed, {done.returncode}: {' '.join(str(part) for part in command)}")
    return done.stdout


def check_folders(shaders, backends, expected_backends):
    """The folder that an engine passes to its shader compiler, and that of the backends."""
    assert shaders.name == "include" and INCLUDES <= {p.name for p in shaders.iterdir()}, shaders
    assert {p.name for p in backends.iterdir()} == expected_backends, backends


def check_places(root):
    installed = {str(p.relative_to(root / prefix.relative_to("/"))) for p in root.rglob("*") if not p.is_dir()}
    libraries = next(p for p in root.rglob("libcsm.so")).parent
    names = {p.name for p in libraries.iterdir() if p.is_file()}
    assert names - {"libcsm.a"} == {"libcsm.so", "libcsm.so.1", "libcsm.so.1.0.0"}, names
    for header in (source / "api/include/csm").iterdir():
        assert header.suffix != ".h" or f"include/csm/{header.name}" in installed, f"{header.name} is not installed"
    for path in installed:
        assert path.startswith(("include/csm/", "lib")), f"{path} is none of csm's places"
    return libraries


def check_pkg_config(root, libraries, backends):
    environment = dict(os.environ, PKG_CONFIG_LIBDIR=str(libraries / "pkgconfig"), PKG_CONFIG_SYSROOT_DIR=str(root),
                       LD_LIBRARY_PATH=str(libraries))
    flags = run("pkg-config", "--cflags", "--libs", "csm", env=environment).split()
    run(*cc, "-x", "c", "-", "-x", "none", *flags, "-o", root / "program", input=PROGRAM)
    run(root / "program", env=environment)
    folders = [run("pkg-config", f"--variable={name}", "csm", env=environment).strip() for name in ("shaderdir", "backenddir")]
    check_folders(*(root / pathlib.Path(folder).relative_to("/") if not folder.startswith(str(root))
                    else pathlib.Path(folder) for folder in folders), backends)


def check_cmake(root, project, backends):
    if not shutil.which("cmake"):
        print("cmake is not installed: the CMake package is not tried")
        return
    project.mkdir()
    (project / "CMakeLists.txt").write_text(CMAKE)
    (project / "program.c").write_text(PROGRAM)
    where = f"-DCMAKE_PREFIX_PATH={root / prefix.relative_to('/')}"
    compiler = ";".join(cc)
    run("cmake", "-S", project, "-B", project / "build", where, f"-DCMAKE_C_COMPILER={compiler}")
    run("cmake", "--build", project / "build")
    run(project / "build/program")
    check_folders(*map(pathlib.Path, (project / "build/folders").read_text().split()), backends)
    (project / "CMakeLists.txt").write_text(CMAKE.replace("csm 1 ", "csm 2 "))
    done = subprocess.run(["cmake", "-S", project, "-B", project / "other", where], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    assert done.returncode and "compatible" in done.stdout, f"another major version is taken:\n{done.stdout}"


def check_subproject(project):
    (project / "subprojects").mkdir(parents=True)
    (project / "subprojects/csm").symlink_to(source)
    (project / "meson.build").write_text(MESON)
    (project / "program.c").write_text(PROGRAM)
    (project / "where.c").write_text(WHERE)
    run("meson", "setup", project / "build", project, "-Dbuildtype=plain", "-Dcsm:vulkan=disabled",
        "-Dcsm:d3d12=disabled", env=dict(os.environ, CC=" ".join(cc)))
    # Compiling hundreds of shaders once more takes long: by their content, those of the build are taken
    shutil.copytree(pathlib.Path(build, "shaders/spirv"), project / "build/subprojects/csm/shaders/spirv")
    run("ninja", "-C", project / "build", "shared", "static", "where")
    for name in ("shared", "static"):
        run(project / "build" / name)
    needed = run("objdump", "-p", project / "build/static")
    told = run(project / "build/where", cwd="/")
    assert f"no libcsm-vulkan.so in {(project / 'build').resolve()} or " in told, told
    names = {line.split()[-1] for line in run("nm", "-g", "--defined-only", next((project / "build").rglob("libcsm.a")))
             .splitlines() if len(line.split()) == 3}
    assert len(names) > 20 and all(name.startswith("csm_") for name in names), names
    assert "libcsm" not in needed and "libcsm" in run("objdump", "-p", project / "build/shared"), needed


os.environ.pop("LD_LIBRARY_PATH", None)  # else the library that was built is taken for the installed one
with tempfile.TemporaryDirectory() as folder:
    root = pathlib.Path(folder, "root")
    run("meson", "install", "-C", build, "--no-rebuild", "--quiet", "--destdir", root)
    libraries = check_places(root)
    plugins = {p.name for p in (libraries / "csm").iterdir()}
    assert plugins and plugins <= {"libcsm-vulkan.so", "libcsm-d3d12.so"}, plugins
    check_pkg_config(root, libraries, plugins)
    check_cmake(root, pathlib.Path(folder, "cmake"), plugins)
    check_subproject(pathlib.Path(folder, "meson"))
print("what is installed is in its places, and pkg-config, CMake and Meson lead to it")
