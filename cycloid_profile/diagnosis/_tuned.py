"""Tuned numbers of the search and of the error of the model, each with its reason."""

# Error of the model: from comparisons of our solvers with independent ones and with each other.
CONTACT_LAW = 0.12  # of the approach: the spread of six published laws
BODY_OF_RIGID_DISC = 0.5  # of the approach: a finite-element disc moves the flank as far as the contact
BODY_OF_ELASTIC_DISC = 0.15  # of the approach: meshes, holes and pillars left out
HOLES = 1.0  # of what the holes of an elastic disc make softer: bolts, pillars and rings in them are left out
BEARING_STIFFNESS = 0.2  # of the bearing's stiffness: catalogue values scatter by as much
PINS = 0.02  # of these errors: their second order, which moves the torque at which further pins bear
PINS_OF_TURN = 0.1  # of what effects add to these errors at all multiples of lobes or pins: corners of a turn
FORM = 0.02  # of an effect, for each slow modulation of its pattern
SCALE = 0.02  # of the size of an effect that curves show: laws and bodies that are all reasonable differ by as much
LAW_OF_JOINT = 0.1  # of the twist of a joint that stiffens, in each octave of torque: power laws and knees differ so
# Of the whole twist of a loop, along its path: printed parts soften, warm up, stick and slip. Metal has no such error.
LOOP_PATH = {"ground": 0.0, "machined": 0.0, "printed": 0.04}
LOOP_PATH_STEP = 0.05  # of the largest torque: distance over which that error changes
REVERSAL = 0.5  # of friction just after a reversal, where it slips in many forms
DRIFT = 4.0  # times the noise, from the middle to either end: an instrument drifts less, a part that creeps more

# Search.
ADDITIONS = 8  # kinds of sets with one more effect, and as many with two more, fitted about an optimum
EXCHANGES = 3  # kinds of sets with one effect exchanged, fitted for each member
# Best sets whose neighbours are fitted, on few rows and on all; half as many single effects come before them.
BEAM, BEAM_ON_ALL_ROWS = 6, 2
EXPANSIONS, EXPANSIONS_ON_ALL_ROWS = 12, 4  # sets whose neighbours are fitted at most
# Exact fits without a clearly better set, after which the search ends, before those of parts of the best set.
FITS, FITS_ON_ALL_ROWS = 75, 24
LEAST_GAIN = 0.5  # of chi² by a further step of a fit in the search
OPEN = 12.0  # of the evidence on all rows: sets this much worse than the best are not pursued
# Of the evidence: the same for large effects, whose linear equations err; on all rows they start near the optimum.
LINEAR_ERROR, LINEAR_ERROR_ON_ALL_ROWS = 0.02, 0.002
MOST_EFFECTS = 5  # of a set: with two expected, one reducer in sixty has more; what needs more is no explanation
DETERMINED = 2.0  # standard deviations from zero: a member below adds no name, only the error of its form
DISTINGUISHED = 4.5  # half chi²: three standard deviations between two explanations
LARGEST_GROUP = 5  # names: what more effects explain equally is a remainder next to an effect that has a name
CLOSED = 0.8  # of the rms: what effects must close if others next to them are not named
FINITE = 12  # single effects fitted from a finite size, and pairs of them on loops
FINITE_AROUND = 27  # the same from other angles and lobes on loops: one for each of 27 effects and parts

# Orders of a turn.
PRODUCTS = 12  # multiples of lobes times pins at which equal parts leave a ripple: of few lobes many are seen
SEEN_ORDER = 0.3  # standard errors: a nuisance column of less width hides at most a twelfth of an amplitude
LOW_ORDERS = 12  # up to here a wave is a form error, of clamping or of runout; more waves are chatter
