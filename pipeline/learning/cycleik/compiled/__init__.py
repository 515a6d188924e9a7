"""The answers of `Experts` compiled, without a tensor library."""

from robots.compiled_cache import use_own_folder

# Before the modules of this package declare compiled functions; what is imported later, of other
# packages, may be kept there too.
use_own_folder("pipeline/learning/cycleik/compiled", "baselines", "robots")
