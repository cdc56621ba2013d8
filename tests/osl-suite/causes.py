"""Why directories of the reference implementation's suite fail, found by hand. run.py puts these sentences into its report.

"Bounces between facets" are docs/adr/0017, "separable masking" is docs/adr/0004, "layers" are docs/adr/0016; docs/testrender.md tells
what else differs from the reference's renderer. The reference reads its sun from a table, which makes it 1.4 % too bright ("the table's sun").
"""

CAUSES = {
    "blackbody": "32 pixels differ by one unit of the last place of the half floats in which the picture is stored.",
    "debug-uninit": "Messages lack the number of the operation and its argument, and arrays are not followed by element: "
    "two reads by splines and an empty file name go unreported.",
    "draw_string": "Our oslutil.h has letters of its own, 5 by 7 points drawn twice as high; the reference's are another font.",
    "gettextureinfo-udim": "What it asks agrees; the labels are drawn by draw_string, whose letters are our own (see draw_string).",
    "layers-entry": "Compares a trace that the reference's generated code prints when it enters layers (llvm_debug_layers).",
    "layers-lazyerror": "The reference's run-time optimiser warns; ours has no such warnings.",
    "ocio": "No OpenColorIO configuration is read, so its colour spaces are unknown.",
    "opt-warnings": "The reference's run-time optimiser warns; ours has no such warnings.",
    "pointcloud": "Bug: a search clears the derivatives of the whole array, the reference only of the points found; 1 of 17 pictures "
    "looks at the rest.",
    "pointcloud-fold": "The same 16 points in another order: unsorted searches come in the order of the reference's library, "
    "ours always sorted by distance.",
    "render-background": "Our Ward lobe is the form with bounded albedo (kernels/bsdf/ward.h), and directions are drawn from the "
    "background by another method.",
    "render-bumptest": "16 pixels: single paths that rounding turns elsewhere; the means agree to 0.01 %.",
    "render-bunny": "4 pixels: single paths that rounding turns elsewhere; the means agree to 0.002 %.",
    "render-displacement": "59 pixels: single paths that rounding turns elsewhere; the means agree to 0.02 %.",
    "render-furnace-diffuse": "20 pixels by 0.009 at most: noise, since directions are drawn from the background by another method; "
    "the means agree.",
    "render-microfacet": "Noise, since directions are drawn from the background by another method, and separable masking where the "
    "reference's is correlated.",
    "render-mx-anisotropic-vdf": "Media are not simulated; a shader of type volume is refused on a surface.",
    "render-mx-burley-diffuse": "The table's sun; and the rough sphere's lobe is bounded where Burley's formula makes light "
    "(kernels/bsdf/burley_diffuse.h).",
    "render-mx-conductor": "Bounces between facets are lost and masking is separable, both on purpose; the table's sun.",
    "render-mx-dielectric": "Bounces between facets are lost and masking is separable, both on purpose; the table's sun.",
    "render-mx-dielectric-glass": "Bounces between facets are lost, on purpose; the reference also makes lobes rougher behind rough "
    "ones; the table's sun.",
    "render-mx-furnace-burley-diffuse": "The lobe is bounded where Burley's formula makes light; spheres of roughness 0 to 0.3 agree "
    "to 0.02 %.",
    "render-mx-furnace-sheen": "Noise: mode 0 maps random numbers to directions otherwise, and a sample takes one lobe, not the "
    "mixture; each sphere's mean agrees to 0.03 %.",
    "render-mx-generalized-schlick": "Mostly bounces between facets, lost on purpose: the sphere of roughness 1 is half as bright; "
    "the table's sun.",
    "render-mx-generalized-schlick-glass": "Bounces between facets are lost, on purpose; the reference also makes lobes rougher "
    "behind rough ones; the table's sun.",
    "render-mx-layer": "The green base shows through a diffuse top: ours lets through what a top does not reflect, the reference "
    "nothing.",
    "render-mx-medium-vdf": "Media are not simulated; a shader of type volume is refused on a surface.",
    "render-mx-medium-vdf-glass": "Media are not simulated: light passes as through a vacuum, and a warning says so.",
    "render-mx-sheen": "The table's sun, and noise, since mode 0 and the background map random numbers to directions otherwise.",
    "render-raytypes": "Noise of 4 samples a pixel under a bright background, from which directions are drawn by another method; "
    "means of many samples agree.",
    "render-spi-thinlayer": "The closure thinlayer is that renderer's own and has no mapping: it contributes nothing.",
    "render-veachmis": "A few pixels: single paths that rounding turns elsewhere; the means agree to 0.03 %.",
    "render-ward": "Our Ward lobe is the form with bounded albedo (kernels/bsdf/ward.h), on purpose.",
    "splineinverse": "Derivatives are exact (1 over the spline's slope); the reference's are carried through its root finder, "
    "off by up to 0.01 %.",
    "texture-errormsg": "The reference's library says only once why a file cannot be opened and \"unknown\" from then on; ours says "
    "why at each look-up.",
    "texture-udim": "OpenImageIO found no font on the machine that ran the suite, so the test's own pictures could not be made.",
    "texture3d": "The volume is an OpenVDB file, which is not read: the texture counts as black, and a warning says so.",
}
