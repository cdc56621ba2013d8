// Edges of polygons, and text, for shaders that show what is going on.
#ifndef OSLUTIL_H
#define OSLUTIL_H

// 1 on the edges of the polygon being shaded, 0 elsewhere and on diffuse rays. edge_type: "triangles", "polygons" or "patches";
// line_width: in pixels where raster is not 0, else in the units of the scene. The renderer tells the corners by the attributes
// geom:trianglevertices, geom:numpolyvertices and geom:polyvertices; without them there are no edges.
float wireframe(string edge_type, float line_width, int raster)
{
    point corners[64];
    int count = 0;
    if (raytype("path:diffuse"))
        return 0;
    if (edge_type == "triangles") {
        count = getattribute("geom:trianglevertices", corners) ? 3 : 0;
    } else if (edge_type == "polygons" || edge_type == "patches") {
        getattribute("geom:numpolyvertices", count);
        if (count < 3 || !getattribute("geom:polyvertices", corners))
            count = 0;
    }
    float width = 0.5 * line_width;
    if (raster) {
        // The mean extent of a pixel across the view.
        vector x = Dx(P) - dot(Dx(P), I) * I;
        vector y = Dy(P) - dot(Dy(P), I) * I;
        width *= 0.5 * (length(x) + length(y));
    }
    float on_edge = 0;
    for (int i = 0; i < count; i++) {
        vector edge = corners[i] - corners[i > 0 ? i - 1 : count - 1];
        vector area = cross(edge, P - corners[i]);
        // The distance to the edge's line is |area| / |edge|.
        if (dot(area, area) < dot(edge, edge) * width * width)
            on_edge = 1;
    }
    return on_edge;
}

float wireframe(string edge_type, float line_width) { return wireframe(edge_type, line_width, 1); }
float wireframe(string edge_type) { return wireframe(edge_type, 1.0, 1); }
float wireframe() { return wireframe("polygons", 1.0, 1); }

// 1 where text covers the point (s, t), in pixels of characters 8 wide and 14 high, from the top left. The text may repeat along s and t,
// shifted by its hash where jitter is not 0. The letters are 5 wide and 7 high, drawn twice as high.
float draw_string(string str, float s, float t, int wrap_s, int wrap_t, int jitter)
{
    // ASCII 33 to 126: columns of 7 bits, the top one lowest; four columns, then the fifth.
    int letters[188] = {
        1556480, 0, 14680960, 0, 266682260, 20, 90166564, 18, 209848739, 98, 72705206, 80, 49792, 0, 136875520, 0, 59285632,
        0, 17794068, 20, 17794056, 8, 796672, 0, 16909320, 8, 1585152, 0, 8521760, 2, 145909950, 62, 136306944, 0, 154431682,
        70, 158425249, 49, 266635800, 16, 145842855, 57, 154297660, 48, 10647681, 3, 154297526, 54, 87188614, 30, 891648, 0,
        895744, 0, 136874504, 0, 42273300, 20, 42508416, 8, 20201602, 6, 138306738, 62, 35932414, 126, 154297599, 54,
        137388222, 34, 72376575, 28, 154297599, 65, 19023103, 1, 154296510, 122, 16909439, 127, 138403968, 0, 133193760, 1,
        71631999, 65, 135274623, 64, 4391295, 127, 33686143, 127, 137388222, 62, 19023103, 6, 70541502, 94, 86394111, 70,
        154297542, 49, 4178049, 1, 135274559, 63, 68161567, 31, 135143487, 63, 42076771, 99, 18613255, 7, 145909985, 67,
        137396096, 0, 33686018, 32, 267411584, 0, 4210948, 4, 135274560, 64, 8421504, 0, 177547808, 120, 143729791, 56,
        143729208, 32, 152117816, 127, 177547832, 24, 2260744, 2, 173320460, 62, 8455295, 120, 136274432, 0, 129048608, 0,
        143263871, 0, 136306816, 0, 8782460, 120, 8455292, 120, 143729208, 56, 42273404, 8, 50661896, 124, 8455292, 8,
        177547848, 32, 135339908, 32, 68165692, 124, 68161564, 28, 135012412, 60, 84153412, 68, 169093132, 60, 160772676, 68,
        137200640, 0, 2080768, 0, 17670272, 0, 33686544, 8
    };
    // `mod` of ints keeps the sign.
    int wrapped(int a, int n) { return mod(mod(a, n) + n, n); }
    int width = strlen(str) * 8;
    int shift = jitter ? hash(str) : 0;
    int x = int(floor(s));
    int y = int(floor(t));
    if (wrap_s)
        x = wrapped(x + (shift & 15), width + 14);
    if (wrap_t)
        y = wrapped(y + ((shift >> 16) & 15), 28);
    int index = x / 8;
    int column = x - index * 8 - 1;
    if (x < 0 || x >= width || column < 0 || column > 4 || y < 0 || y > 13)
        return 0;
    int letter = getchar(str, index) - 33;
    if (letter < 0 || letter > 93)
        return 0;
    int bits = letters[2 * letter + (column > 3)] >> (column > 3 ? 0 : 7 * column);
    return (bits >> (y / 2)) & 1;
}

#endif
