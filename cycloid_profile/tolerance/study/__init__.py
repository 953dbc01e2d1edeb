"""Monte Carlo studies: draws, chunks, workers, storage and summaries."""

from cycloid_profile.tolerance.study.chunks import Study as Study
from cycloid_profile.tolerance.study.comparison import Comparison as Comparison
from cycloid_profile.tolerance.study.comparison import compare_designs as compare_designs
from cycloid_profile.tolerance.study.draws import SEQUENCES as SEQUENCES
from cycloid_profile.tolerance.study.draws import Draws as Draws
from cycloid_profile.tolerance.study.draws import Random as Random
from cycloid_profile.tolerance.study.draws import Sobol as Sobol
from cycloid_profile.tolerance.study.draws import generator as generator
from cycloid_profile.tolerance.study.statistics import Interval as Interval
from cycloid_profile.tolerance.study.statistics import histogram as histogram
from cycloid_profile.tolerance.study.statistics import percent as percent
from cycloid_profile.tolerance.study.statistics import share_interval as share_interval
from cycloid_profile.tolerance.study.store import Store as Store
from cycloid_profile.tolerance.study.summary import QuantitySummary as QuantitySummary
from cycloid_profile.tolerance.study.summary import StudySummary as StudySummary
from cycloid_profile.tolerance.study.summary import Yield as Yield
from cycloid_profile.tolerance.study.summary import summarise as summarise
from cycloid_profile.tolerance.study.workers import Cluster as Cluster
from cycloid_profile.tolerance.study.workers import ParallelQuantities as ParallelQuantities
from cycloid_profile.tolerance.study.workers import Threads as Threads
from cycloid_profile.tolerance.study.workers import Workers as Workers
from cycloid_profile.tolerance.study.workers import chunk_values as chunk_values
from cycloid_profile.tolerance.study.workers import cores as cores
from cycloid_profile.tolerance.study.workers import on_all_cores as on_all_cores
from cycloid_profile.tolerance.study.workers import portable as portable
from cycloid_profile.tolerance.study.workers import run as run
