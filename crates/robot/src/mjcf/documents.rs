use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use crate::RobotError;
use crate::description::mesh_path::is_file_like;
use crate::description::text_source::read;
use crate::description::xml::{Element, XmlText};
use crate::model_file::unread_list::not_supported;

/// Maximum number of files of a model; the largest known one has 30.
const MOST_FILES: usize = 200;

/// Maximum length of all files of a model together, in bytes.
const MOST_BYTES: usize = 64 << 20;

/// Texts of a model and of all files that it includes, directly or indirectly.
pub(crate) struct Sources {
    files: Vec<SourceFile>,
}

struct SourceFile {
    name: String,
    text: String,
    /// Index of each file that this one includes, by its name there.
    includes: HashMap<String, usize>,
}

impl Sources {
    /// Reads the files included in `text`, the content of `path`. A name is relative to the folder of `path`, or else to that of
    /// the including file. Each file is included once, as in `MuJoCo`, so that no cycle is possible.
    pub(crate) fn read(text: String, path: &Path) -> Result<Self, RobotError> {
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        let known_as = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let mut known = HashSet::from([known_as(path)]);
        let mut files = vec![SourceFile { name: path.display().to_string(), text, includes: HashMap::new() }];
        let mut folders = vec![folder.to_owned()];
        let mut bytes = files[0].text.len();
        let mut next = 0;
        while next < files.len() {
            let mut found: Vec<(String, SourceFile, PathBuf)> = Vec::new();
            let file = &files[next];
            let xml = XmlText::parse(&file.text, &file.name)?;
            for element in xml.root().within().filter(|element| element.tag() == "include") {
                let name = element.text("file")?;
                let plain = name.replace('\\', "/");
                let tried = [folder.join(&plain), folders[next].join(&plain)];
                let path = tried.iter().find(|path| is_file_like(path)).unwrap_or(&tried[0]);
                if !known.insert(known_as(path)) {
                    let what = format!("a second <include> of {}", path.display());
                    return Err(not_supported(element, what, "include each file once"));
                }
                if files.len() + found.len() >= MOST_FILES {
                    let (at, actual) = (element.at(), MOST_FILES + 1);
                    return Err(RobotError::TooMany { at, what: "included files", most: MOST_FILES, actual });
                }
                let text = read(cranny_file::TEXT, path)?;
                bytes += text.len();
                if bytes > MOST_BYTES {
                    let (what, most) = ("bytes in all included files", MOST_BYTES);
                    return Err(RobotError::TooMany { at: element.at(), what, most, actual: bytes });
                }
                let source = SourceFile { name: path.display().to_string(), text, includes: HashMap::new() };
                let folder = path.parent().map(Path::to_owned).unwrap_or_default();
                found.push((name.to_owned(), source, folder));
            }
            for (name, source, folder) in found {
                let index = files.len();
                files[next].includes.insert(name, index);
                files.push(source);
                folders.push(folder);
            }
            next += 1;
        }
        Ok(Self { files })
    }

    /// Parses all files.
    pub(crate) fn documents(&self) -> Result<Documents<'_>, RobotError> {
        let texts = self.files.iter().map(|file| XmlText::parse(&file.text, &file.name));
        Ok(Documents { sources: self, texts: texts.collect::<Result<_, _>>()? })
    }
}

/// Parsed files of a model. An `<include>` counts as the elements inside the outermost element of its file.
pub(crate) struct Documents<'s> {
    sources: &'s Sources,
    texts: Vec<XmlText<'s>>,
}

impl Documents<'_> {
    /// Outermost element of the model.
    pub(crate) fn root(&self) -> Option<Element<'_>> {
        self.texts.first().map(XmlText::root)
    }

    /// Returns the elements inside an element, with those of included files.
    pub(crate) fn children<'d>(&'d self, of: Element<'d>) -> Vec<Element<'d>> {
        let mut children = Vec::new();
        self.collect(of, &mut children);
        children
    }

    fn collect<'d>(&'d self, of: Element<'d>, children: &mut Vec<Element<'d>>) {
        for child in of.inner() {
            if child.tag() != "include" {
                children.push(child);
                continue;
            }
            let source = self.sources.files.iter().find(|file| file.name == child.file());
            let name = child.optional_text("file").unwrap_or_default();
            if let Some(&included) = source.and_then(|source| source.includes.get(name)) {
                self.collect(self.texts[included].root(), children);
            }
        }
    }

    /// Returns the elements named `tag` directly inside the outermost element, in the order of the files.
    pub(crate) fn sections<'d>(&'d self, tag: &'static str) -> impl Iterator<Item = Element<'d>> {
        let all = self.root().map(|root| self.children(root)).unwrap_or_default();
        all.into_iter().filter(move |section| section.tag() == tag)
    }
}
