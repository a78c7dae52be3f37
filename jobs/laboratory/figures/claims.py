"""What the survey shows and says, figure by figure: its captions and claims as short facts, none of its sentences.

The page says "The survey says" with nothing but these, and a test holds it to that.
"""
from typing import NamedTuple


class Caption(NamedTuple):
    title: str       # what the figure shows, under the survey's number; of figures of our own, their subject
    claim: str = ""  # what the survey says of it; empty: nothing, or the figure is ours


CAPTIONS = {
    "1": Caption("Figure 1: the shapes of the discrepancy tests: rectangle, triangle and quarter circle, with a corner at "
                 "the origin"),
    "point-sets": Caption("Point sets in the unit square"),
    "2": Caption("Figure 2: a stretched square with a uniform curve, an adaptive curve, and an adaptive curve after "
                 "reparameterization",
                 "An adaptive curve copes with stretch as far as the precision of numbers allows; a reparameterization "
                 "balances its tree."),
    "3": Caption("Figure 3: the first two iterations of the Hilbert, the Peano and the variant Peano curve",
                 "Of the three curves Hilbert's is the one of choice."),
    "4-plane": Caption("Figure 4, plane: discrepancy by number of points",
                       "Stratified points along a Hilbert curve equal the best sets on quarter circles, are better than "
                       "low-discrepancy sets on triangles, and worse on rectangles."),
    "4-placement": Caption("Placement of samples: at vertices of the curve and inside of its elements",
                           "Samples lie at vertices of the curve."),
    "4-sphere": Caption("Figure 4, sphere: discrepancy by number of points",
                        "Samples of the sphere are as good as those of methods made for it."),
    "4-mesh": Caption("Figure 4, meshes: discrepancy by number of points",
                      "Samples of meshes, measured over patches that grow ring by ring, have the rate of the plane."),
    "5": Caption("Figure 5: three densities in the plane: samples, and discrepancy by number of points",
                 "The rate of uniform samples holds for varying densities."),
    "6": Caption("Figure 6: the eight surface: parameterization, adaptive curve, samples uniform and by mean curvature"),
    "7": Caption("Figure 7: the squirrel, from the mesh over chart and curve to splats"),
    "8": Caption("Figure 8: a uniform and an adaptive curve on a mesh",
                 "A uniform curve crowds where the parameterization shrinks; an adaptive one covers the surface evenly."),
    "9": Caption("Figure 9: the lion splatted with uniform samples, with samples by mean curvature, and rendered"),
    "10": Caption("Figure 10: igea remeshed uniformly and by mean curvature, and rendered",
                  "With 25 % of the triangles the mean distance is .02 % of the diagonal."),
    "11": Caption("Figure 11: more samples at the silhouette: a sphere from several angles, and the bunny"),
    "12": Caption("Figure 12: the curve aligned to the parameterization, and aligned to the field"),
    "13": Caption("Figure 13: segments in the plane, on the surface, their chains of curves, and samples"),
    "14": Caption("Figure 14: the six steps of the sampling of a segment"),
    "15": Caption("Figure 15: discrepancy of anisotropic samples by number of points"),
    "16": Caption("Figure 16: samples, spectrum, radial mean and anisotropy of differences: Gaussian blob, Balzer's "
                  "function, bunny uniform and by mean curvature",
                  "2,500 samples of the blob, 10,000 of Balzer's function and 3,000 of the bunny have the differences of "
                  "blue noise, alike in all directions."),
    "16-tensor": Caption("Differences of anisotropic samples"),
    "17": Caption("Figure 17: the dragon with isotropic and with anisotropic splats",
                  "Anisotropic splats leave less of the surface open."),
    "18": Caption("Figure 18: the knot in strokes"),
    "19": Caption("Figure 19: the eight of genus 2 in strokes"),
    "20": Caption("Figure 20: Venus in strokes"),
    "21": Caption("Figure 21: the four meshes of the tests of descriptors"),
    "metro": Caption("Remeshed models beside simplified ones: distances to the model"),
    "22": Caption("Figure 22: the bunny: histogram of Euclidean distances, relative and largest error"),
    "23": Caption("Figure 23: Max Planck: histogram of Euclidean distances, relative and largest error"),
    "24": Caption("Figure 24: the fandisk: histogram of Euclidean distances, relative and largest error"),
    "25": Caption("Figure 25: the hand: histogram of Euclidean distances, relative and largest error"),
    "26": Caption("Figure 26: the hand: histogram of geodesic distances, relative and largest error"),
    "table-1": Caption("Table 1: errors of histograms of 100 and 500 samples",
                       "Low-discrepancy samples have smaller errors than random ones in all 16 cells."),
    "histogram-floors": Caption("What remains of the error of histograms with many samples"),
    "spaced": Caption("Spaced samples by every measure"),
    "spaced-sets": Caption("Spaced samples beside others on models"),
    "limit": Caption("Every sequence against the least error that is known to be possible"),
}
