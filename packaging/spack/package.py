"""Recipe for Spack, which builds the tree that it is called in: put it into packages/mlgimp of a repository of yours, then
`spack dev-build mlgimp@develop` in the top folder."""
from spack.package import *


class Mlgimp(MakefilePackage):
    """Generalized interpolation material point method for indentation and contact on nested grid levels."""

    version("develop")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("gmake", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mpi")
    depends_on("petsc@3.18:+mpi+double~complex")
    depends_on("hdf5@1.10:+mpi")
    depends_on("metis@5:")
    depends_on("nlohmann-json")
    depends_on("python@3.9:", type=("build", "run"))
    depends_on("py-numpy", type="run")
    depends_on("py-scipy", type="run")
    depends_on("py-h5py", type="run")
    depends_on("py-matplotlib", type="run")

    def common_arguments(self):
        """Arguments of both `make` and `make install`; Spack's compilers choose the processor."""
        return [f"CXX={self.spec['mpi'].mpicxx}", "ARCH=", "HDF5=hdf5", f"PYTHON={self.spec['python'].command.path}"]

    def build(self, spec, prefix):
        make(*self.common_arguments())

    def install(self, spec, prefix):
        make(*self.common_arguments(), f"PREFIX={prefix}", "install")
